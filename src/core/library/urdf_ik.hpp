// urdf-ik for C++: every inverse-kinematics solution of an arm that `urdf-ik compile` wrote to a file.
//
//     const urdf_ik::Arm arm = urdf_ik::Arm::load("arm.json");
//     std::vector<double> q(arm.columns() * arm.joints());
//     std::vector<std::uint8_t> flags(arm.columns());
//     arm.ik(T, 1, q.data(), flags.data());            // T: sixteen numbers, row by row
//     for (int c = 0; c < arm.columns(); ++c) if (urdf_ik::Arm::valid(flags[c])) use(&q[c * arm.joints()]);
//
// Lengths are m, angles rad, joint vectors base to tip, poses 4x4 of the tip link in the base link, row by row. An arm is
// immutable: any number of threads may use one at once. No function but load and parse allocates, except for the solver of arms
// whose joints drive several axes each, which takes one piece of memory a call. No function throws.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace urdf_ik {

class __attribute__((visibility("default"))) Arm {
public:
    struct Joint {
        std::string name, type;  // "revolute", "continuous" or "prismatic"
        double lower, upper;     // limits; infinite where there are none
        double velocity;         // greatest speed by the URDF; infinite where it gives none
        double turn;             // how far the images of a value are apart [rad]; 0: it has none
    };
    // What a pose leaves free: "swivel", "locked joint" or "free axis".
    struct Parameter {
        std::string kind, name, unit;
        double lower, upper, default_value;
    };
    // Of the solutions of a pose.
    enum class Status : std::uint8_t {
        complete = 0,     // every solution is there, once
        incomplete = 32,  // solutions may be missing
        clustered = 64,   // every solution is counted; solutions nearer to each other than rounding stand as one
        continuum = 96,   // a curve of solutions keeps the pose: representatives of it are there
    };

    // The arm of a file or of a file's text. If there is none, the arm is empty and `error` says why.
    static Arm load(const std::string& file, std::string* error = nullptr);
    static Arm parse(std::string_view text, std::string* error = nullptr);
    explicit operator bool() const { return data_ != nullptr; }
    // All other functions need an arm that is not empty.

    const std::string &name() const, &base() const, &tip() const, &family() const;
    int joints() const;      // numbers of a joint vector
    int columns() const;     // joint vectors of an answer: as many as a pose has solutions at most
    int parameters() const;  // redundancy parameters
    const Joint& joint(int k) const;
    const Parameter& parameter(int k) const;
    const std::string& branch_name(int column) const;
    // Whether the arm was compiled from this text of a URDF.
    bool compiled_from(std::string_view urdf) const;

    // All solutions of m poses T (m, 4, 4): q (m, columns, joints), flags (m, columns). Angles are in (-pi, pi].
    // q_ref (joints): on a continuum, free joints take values near these. values (m, parameters): of the redundancy parameters;
    // null: the defaults. Returns the index of the first T that is no pose, or -1; then the answers of that pose and of those
    // behind it are undefined.
    long ik(const double* T, long m, double* q, std::uint8_t* flags, const double* q_ref = nullptr,
            const double* values = nullptr) const;
    // Of a column: whether it holds a solution, and whether this is singular.
    static bool valid(std::uint8_t flags) { return flags & 1; }
    static bool singular(std::uint8_t flags) { return flags & 30; }
    // Of a pose: `flags` are those of its columns.
    static Status status(const std::uint8_t* flags) { return static_cast<Status>(flags[0] & 96); }

    // Poses T (m, 4, 4) and Jacobians J (m, 6, joints), linear rows above angular ones, for joint vectors q (m, joints).
    void fk(const double* q, long m, double* T) const;
    void jacobian(const double* q, long m, double* J) const;
    // The values (parameters) of the redundancy parameters for which ik gives the solution q (joints) of the pose T.
    void redundancy_of(const double* q, const double* T, double* values) const;

    // The column of a pose's solutions nearest to q_ref (joints), by sqrt(sum of weight * difference^2); weights (joints), null: 1
    // each. -1: there is none. inside: each solution counts by its image nearest to q_ref inside the joint limits, which is written
    // to nearest (joints), and the difference is the whole motion; otherwise the difference of angles is taken on the circle.
    int nearest(const double* q, const std::uint8_t* flags, const double* q_ref, double* nearest, bool inside = true,
                const double* weights = nullptr) const;
    // The images of a joint vector inside the joint limits, whole turns away, fewest turns first, the last joint fastest. Writes
    // the first `most` to images (most, joints), and returns how many there are, at most 1e9.
    long turns(const double* q, double* images, long most) const;

private:
    struct Data;
    std::shared_ptr<const Data> data_;
};

}  // namespace urdf_ik
