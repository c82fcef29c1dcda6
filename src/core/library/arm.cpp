// See urdf_ik.hpp.
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <vector>

#include "certify/status.hpp"
#include "library/json_values.hpp"
#include "library/sha256.hpp"
#include "library/urdf_ik.hpp"
#include "propose/images.hpp"
#include "solvers/solver.hpp"

namespace urdf_ik {

static_assert(STATUS_BITS == 96 && SINGULAR == 30 && VALID == 1, "as urdf_ik.hpp says");

namespace {

constexpr const char* FORMAT = "urdf-ik compiled arm";
constexpr int VERSION = 1;
// Axes of a chain, and rows of its parts.
constexpr int MOST_AXES_OF_A_CHAIN = 64;
// The error that the contract grants to a solution: how far a value may lie beyond a limit [rad, m], and the tip from the poses
// that the file gives, as a share of its distance from the base, or of 1 m.
constexpr double TOLERANCE = 1e-9;

// The product of exponentials of all axes; joints may drive several axes each.
class Kinematics {
public:
    Kinematics(const Values& v, int joints) : joints_(joints) {
        const std::vector<double> slides = v.array("slides");
        axes_ = int(slides.size());
        if (axes_ < 1 || axes_ > MOST_AXES_OF_A_CHAIN || axes_ < joints) throw v.error("slides", "too many or too few axes");
        for (int k = 0; k < axes_; ++k) slides_[k] = slides[std::size_t(k)] != 0.0;
        read_motions(v, "steps", steps_, axes_ + 1);
        if (v.has("gain")) gain_ = v.array("gain");
        if (gain_.empty() ? axes_ != joints : gain_.size() != std::size_t(axes_) * std::size_t(joints)) {
            throw v.error("gain", "as many rows as axes, and columns as joints, are needed");
        }
    }
    Kinematics(const Kinematics&) = delete;

    void poses(const double* q, long m, double* T) const {
        if (gain_.empty()) return level().chain->poses(chain(), q, m, T);
        double values[MOST_AXES_OF_A_CHAIN];
        for (long i = 0; i < m; ++i) {
            spread(q + i * joints_, values);
            level().chain->poses(chain(), values, 1, T + 16 * i);
        }
    }
    void jacobians(const double* q, long m, double* J) const {
        if (gain_.empty()) return level().chain->jacobians(chain(), q, m, J);
        double values[MOST_AXES_OF_A_CHAIN], each[6 * MOST_AXES_OF_A_CHAIN];
        for (long i = 0; i < m; ++i) {
            spread(q + i * joints_, values);
            level().chain->jacobians(chain(), values, 1, each);
            for (int r = 0; r < 6; ++r) {
                for (int j = 0; j < joints_; ++j) {
                    double& sum = J[(6 * i + r) * joints_ + j];
                    sum = 0.0;
                    for (int k = 0; k < axes_; ++k) sum += each[axes_ * r + k] * gain_[std::size_t(joints_ * k + j)];
                }
            }
        }
    }

private:
    ChainArm chain() const { return {axes_, steps_, slides_}; }
    // The values of the axes.
    void spread(const double* q, double* values) const {
        for (int k = 0; k < axes_; ++k) {
            values[k] = 0.0;
            for (int j = 0; j < joints_; ++j) values[k] += q[j] * gain_[std::size_t(joints_ * k + j)];
        }
    }

    int joints_, axes_;
    Motion steps_[MOST_AXES_OF_A_CHAIN + 1];
    bool slides_[MOST_AXES_OF_A_CHAIN];
    std::vector<double> gain_;
};

}  // namespace

struct Arm::Data {
    std::string name, base, tip, family, urdf_hash;
    std::vector<Joint> joints;
    std::vector<Limit> limits;  // of the joints, widened by the tolerance
    std::vector<Parameter> parameters;
    std::vector<std::string> branches;
    std::unique_ptr<const Kinematics> kinematics;
    SolverPointer solver;

    explicit Data(const JsonValues& v) {
        name = v.word("name"), base = v.word("base"), tip = v.word("tip"), family = v.word("family");
        urdf_hash = v.group("urdf")->word("sha256");
        for (const JsonValues& each : v.groups("joints")) {
            joints.push_back({each.word("name"), each.word("type"), each.number("lower"), each.number("upper"),
                              each.number("velocity"), each.number("turn")});
            const Joint& joint = joints.back();
            limits.emplace_back(joint.lower - TOLERANCE, joint.upper + TOLERANCE, joint.turn);
        }
        for (const JsonValues& each : v.groups("parameters")) {
            parameters.push_back({each.word("kind"), each.word("name"), each.word("unit"), each.number("lower"),
                                  each.number("upper"), each.number("default")});
        }
        branches = v.words("branches");
        kinematics = std::make_unique<Kinematics>(*v.group("chain"), int(joints.size()));
        solver = make_solver(*v.group("solver"));
        if (solver->numbers != 16) throw v.error("solver", "a solver of poses is needed");
        if (solver->joints != int(joints.size())) throw v.error("joints", "the solver has " + std::to_string(solver->joints));
        if (solver->branches != int(branches.size())) {
            throw v.error("branches", "the solver has " + std::to_string(solver->branches));
        }
        if (solver->parameters != int(parameters.size())) {
            throw v.error("parameters", "the solver has " + std::to_string(solver->parameters));
        }
        for (const JsonValues& each : v.groups("checks")) check(each);
    }
    // Throws unless forward kinematics gives the pose that the file has.
    void check(const JsonValues& v) const {
        std::vector<double> q(joints.size());
        double wanted[16], T[16];
        v.read("q", q.data(), q.size()), v.read("T", wanted, 16);
        kinematics->poses(q.data(), 1, T);
        double size = 1.0;
        for (const double each : wanted) size = std::max(size, std::fabs(each));
        for (int i = 0; i < 16; ++i) {
            if (!(std::fabs(T[i] - wanted[i]) <= TOLERANCE * size)) throw v.error("T", "the chain leads elsewhere");
        }
    }
};

static void tell(std::string* error, const std::string& text) {
    if (error) *error = text;
}

Arm Arm::parse(std::string_view text, std::string* error) {
    Arm arm;
    try {
        const Json file = read_json(text);
        const JsonValues v(file, "arm");
        if (!v.has("format") || v.word("format") != FORMAT) {
            throw std::invalid_argument(std::string("no compiled arm: it has no \"format\": \"") + FORMAT + "\"");
        }
        if (v.integer("version") != VERSION) {
            throw std::invalid_argument("a compiled arm of version " + std::to_string(v.integer("version")) +
                                        "; this library reads version " + std::to_string(VERSION) +
                                        ": urdf-ik compile writes it anew");
        }
        arm.data_ = std::make_shared<const Data>(v);
    } catch (const std::exception& problem) { tell(error, problem.what()); }
    return arm;
}

Arm Arm::load(const std::string& file, std::string* error) {
    Arm arm;
    try {
        const std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(std::fopen(file.c_str(), "rb"), std::fclose);
        if (!in) return tell(error, file + ": it cannot be read"), arm;
        std::string text;
        char part[4096];
        for (std::size_t read; (read = std::fread(part, 1, sizeof part, in.get())) > 0;) text.append(part, read);
        std::string problem;
        arm = parse(text, &problem);
        if (!arm) tell(error, file + ": " + problem);
    } catch (const std::exception& problem) { tell(error, file + ": " + problem.what()); }
    return arm;
}

const std::string& Arm::name() const { return data_->name; }
const std::string& Arm::base() const { return data_->base; }
const std::string& Arm::tip() const { return data_->tip; }
const std::string& Arm::family() const { return data_->family; }
int Arm::joints() const { return data_->solver->joints; }
int Arm::columns() const { return data_->solver->branches; }
int Arm::parameters() const { return data_->solver->parameters; }
const Arm::Joint& Arm::joint(int k) const { return data_->joints[std::size_t(k)]; }
const Arm::Parameter& Arm::parameter(int k) const { return data_->parameters[std::size_t(k)]; }
const std::string& Arm::branch_name(int column) const { return data_->branches[std::size_t(column)]; }
bool Arm::compiled_from(std::string_view urdf) const { return sha256(urdf) == data_->urdf_hash; }

long Arm::ik(const double* T, long m, double* q, std::uint8_t* flags, const double* q_ref, const double* values) const {
    // Free joints of a continuum take values near these, and answers are in (-pi, pi].
    double wrapped[MOST_AXES_OF_A_CHAIN];
    for (int j = 0; q_ref && j < joints(); ++j) wrapped[j] = principal_value(q_ref[j], joint(j).turn != 0.0);
    return data_->solver->solve({T, m, q_ref ? wrapped : nullptr, values, q, flags, false, m});
}

void Arm::fk(const double* q, long m, double* T) const { data_->kinematics->poses(q, m, T); }
void Arm::jacobian(const double* q, long m, double* J) const { data_->kinematics->jacobians(q, m, J); }

void Arm::redundancy_of(const double* q, const double* T, double* values) const {
    double reached[16];
    fk(q, 1, reached);
    data_->solver->redundancy_of(q, T, reached, values);
}

int Arm::nearest(const double* q, const std::uint8_t* flags, const double* q_ref, double* nearest, bool inside,
                 const double* weights) const {
    const int n = joints();
    int best = -1;
    double least = __builtin_inf();
    for (int c = 0; c < columns(); ++c) {
        if (!valid(flags[c])) continue;
        const double* row = q + c * n;
        double image[MOST_AXES_OF_A_CHAIN], sum = 0.0;
        bool all = true;
        for (int j = 0; j < n && all; ++j) {
            const Limit& limit = data_->limits[std::size_t(j)];
            image[j] = row[j];
            if (inside) all = image_near(row[j], q_ref[j], limit, image[j]);
            double apart = image[j] - q_ref[j];
            if (!inside && limit.turn != 0.0) apart -= limit.turn * std::nearbyint(apart / limit.turn);
            sum += (weights ? weights[j] : 1.0) * apart * apart;
        }
        if (!all || !(sum < least)) continue;
        best = c, least = sum;
        for (int j = 0; j < n; ++j) nearest[j] = image[j];
    }
    return best;
}

// The number of turns to the image of this rank: fewest turns first, of two the one nearer to zero.
static double turns_by_rank(double q, const ImageRange& range, long rank) {
    double low = range.nearest(0.0), high = low;
    double turns = low;
    for (; rank > 0; --rank) {
        const double below = low - 1.0, above = high + 1.0;
        const auto order = [&](double k) { return std::fabs(k) + (k * q > 0.0 ? 0.25 : 0.0); };
        if (above > range.last || (below >= range.first && order(below) <= order(above))) turns = low = below;
        else turns = high = above;
    }
    return turns;
}

long Arm::turns(const double* q, double* images, long most) const {
    const int n = joints();
    ImageRange range[MOST_AXES_OF_A_CHAIN];
    double total = 1.0;
    for (int j = 0; j < n; ++j) {
        range[j] = image_range(q[j], data_->limits[std::size_t(j)]);
        if (range[j].empty()) return 0;
        total *= range[j].last - range[j].first + 1.0;
    }
    const long all = long(std::min(total, 1e9));
    for (long i = 0; i < all && i < most; ++i) {
        long rank = i;
        for (int j = n - 1; j >= 0; --j) {
            const long count = long(std::min(range[j].last - range[j].first + 1.0, 1e9));
            images[n * i + j] = q[j] + turns_by_rank(q[j], range[j], rank % count) * data_->limits[std::size_t(j)].turn;
            rank /= count;
        }
    }
    return all;
}

}  // namespace urdf_ik
