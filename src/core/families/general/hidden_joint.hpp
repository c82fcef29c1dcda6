// Elimination to the angle of one hidden joint, whose determinant is a trigonometric polynomial.
//
// A line with point p and direction l is w = (1, p, h, l, p x l, d, k) with h = p.p / 2, d = p.l, k = h l - d p: fifteen
// numbers on which rigid motions act linearly. In them the loop equation, applied to the axis of joint a + 2, is the
// fourteen equations of Raghavan and Roth (1990), without coordinates. Joints a and a + 1 are removed by the six left null
// vectors of their constant matrix (15 x 9). Multiplying the six equations left by cos and sin of half of joint a + 4's
// angle makes them square (Manocha and Canny 1994 have half-angle tangents instead, and their poles): 12 x 12 in the
// products of (1, cos, sin) of joint a + 3 and the four of degree three of the cosine and the sine of the half angle. The
// determinant is a trigonometric polynomial of degree eight in the hidden joint a + 5; it is sampled, and its 16 roots are
// found in the complex plane.
//
// A joint that slides by d takes part as an angle t with d = tan(t / 2). Its action on lines is of degree two in d, so
// it has the form 1, cos t, sin t up to the factor cos^2(t / 2), which cancels in homogeneous equations.
#pragma once

#include "certify/loop.hpp"
#include "families/general/elimination_arm.hpp"
#include "numbers/doubled.hpp"
#include "numbers/polynomials.hpp"
#include "propose/polish.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

inline constexpr int LINE = 15, SIZE = 12, DEGREE = 8, SAMPLES = 24, GROUPS = SAMPLES / BLOCK;

// Coefficients of the six equations: (1, cos, sin) of the hidden joint, then (1, cos, sin) of joint a + 4, slowest, times
// (1, cos, sin) of joint a + 3.
struct Equations {
    double a[6][3][9];
};

// ---- lines ---------------------------------------------------------------------------------------------------------

// The line w after the motion G.
template <class V> STEP void move_line(const Frame<V>& G, const V (&w)[LINE], V (&out)[LINE]) {
    const auto& t = G.p;
    const V half = 0.5 * dot(t, t);
    const Vec<V> p = G.R * Vec<V>{w[1], w[2], w[3]}, l = G.R * Vec<V>{w[5], w[6], w[7]};
    const Vec<V> m = G.R * Vec<V>{w[8], w[9], w[10]}, k = G.R * Vec<V>{w[12], w[13], w[14]};
    const V along = w[11] + dot(t, l);
    const Vec<V> point = p + w[0] * t, moment = m + cross(t, l), last = k - cross(t, m) + half * l - along * t;
    out[0] = w[0], out[4] = w[4] + dot(t, p) + half * w[0], out[11] = along;
    out[1] = point.x, out[2] = point.y, out[3] = point.z, out[5] = l.x, out[6] = l.y, out[7] = l.z;
    out[8] = moment.x, out[9] = moment.y, out[10] = moment.z, out[12] = last.x, out[13] = last.y, out[14] = last.z;
}

// COLUMNS: the number of products of joints behind the loop's motion.
template <int COLUMNS> PART void equations_with(const EliminationVariant& v, const Frame<double>& G, Equations& A) {
    constexpr int rows = 162 / COLUMNS, blocks = (rows + BLOCK - 1) / BLOCK;
    constexpr int width = COLUMNS < 8 ? COLUMNS : 9, height = blocks < 8 ? blocks : 3;  // what stays in registers
    double moved[LINE][32];
    for (int c = 0; c < COLUMNS; c += BLOCK) {
        Block w[LINE], out[LINE];
        for (int i = 0; i < LINE; ++i) w[i] = load<Block>(v.right[i] + c);
        move_line(spread<Block>(G), w, out);
        for (int i = 0; i < LINE; ++i) store(out[i], moved[i] + c);
    }
    double* a = &A.a[0][0][0];
    for (int c = 0; c < COLUMNS; c += width) {
        for (int b = 0; b < blocks; b += height) {
            Block sum[width][height];
            for (auto& each : sum)
                for (auto& x : each) x = 0.0;
            for (int i = 0; i < LINE; ++i) {
                for (int x = 0; x < width; ++x) {
                    for (int y = 0; y < height; ++y) {
                        if (b + y < blocks) sum[x][y] += moved[i][c + x] * load<Block>(v.left[i] + BLOCK * (b + y));
                    }
                }
            }
            for (int x = 0; x < width; ++x) {
                for (int r = BLOCK * b; r < rows && r < BLOCK * (b + height); ++r) {
                    a[r * COLUMNS + c + x] = sum[x][r / BLOCK - b][r % BLOCK];
                }
            }
        }
    }
}

PART void equations(const EliminationVariant& v, const Frame<double>& G, Equations& A) {
    switch (v.first) {
        case 3:
            return equations_with<1>(v, G, A);
        case 2:
            return equations_with<3>(v, G, A);
        case 1:
            return equations_with<9>(v, G, A);
        default:
            return equations_with<27>(v, G, A);
    }
}

// ---- the matrix ----------------------------------------------------------------------------------------------------

// The matrix at the hidden angles (c, s), column by column. In the cosine C and the sine S of half of joint a + 4 each equation is
// (f + g) C^2 + 2 h C S + (f - g) S^2; rows: C times the equations, then S times these. Columns: C^3, S^3, C^2 S and C S^2, each
// times (1, cos, sin) of joint a + 3. So each row has zeros in three of the first six.
template <class V, class E> STEP void matrix_at(const E& A, const V& c, const V& s, V (&M)[SIZE][SIZE]) {
#pragma GCC unroll 1
    for (int e = 0; e < 6; ++e) {
        const auto& a = A.a[e];
        for (int j = 0; j < 3; ++j) {
            const V f = a[0][j] + c * a[1][j] + s * a[2][j];
            const V g = a[0][3 + j] + c * a[1][3 + j] + s * a[2][3 + j];
            const V h = 0.5 * (a[0][6 + j] + c * a[1][6 + j] + s * a[2][6 + j]);
            const V sum = 0.25 * (f + g), difference = 0.25 * (f - g);
            M[j][e] = sum + sum, M[3 + j][e] = 0.0, M[6 + j][e] = h, M[9 + j][e] = difference;
            M[6 + j][6 + e] = sum, M[9 + j][6 + e] = h, M[3 + j][6 + e] = difference + difference;
        }
    }
}

// A Householder reflection 1 - w v v*: makes column I zero below its diagonal. Its head becomes alpha, the column's length with the
// opposite sign or phase, so that v - alpha e has no cancellation.
template <class V> STEP void reflect(V (&M)[SIZE][SIZE], int I) {
    // So many sums do not wait for each other.
    constexpr int SUMS = IS_CALLED<V> ? 4 : 2;
    // The other rows have zeros in the column: first those of S, then those of C that the first three reflections have left.
    const int N = (I < 3 ? 6 : I < 6 ? 9 : SIZE) - I;
    for (int j = 3; j < SIZE && I == 3; ++j) {
        for (int r = 3; r < 6; ++r) exchange(M[j][r], M[j][6 + r]);
    }
    V v[SIZE], alpha;
    decltype(square(alpha)) all = TINY, w;
#pragma GCC unroll 12
    for (int r = 0; r < N; ++r) v[r] = M[I][I + r], all += square(v[r]);
    if constexpr (!std::is_same_v<V, CBlock>) {
        alpha = -copysign(sqrt(all), v[0]), w = 1.0 / (all - alpha * v[0]);
    } else {
        const Block head = sqrt(square(v[0]) + TINY), length = sqrt(all);
        alpha = scaled(-(length / head), v[0]), w = 1.0 / (all + length * head);
    }
    M[I][I] = alpha;
    v[0] = v[0] - alpha;
#pragma GCC unroll 1
    for (int j = I + 1; j < SIZE; ++j) {
        if (I < 3 && j / 3 == 1) continue;  // S^3, with zeros in these rows
        V sum[SUMS];
        for (V& each : sum) each = 0.0;
#pragma GCC unroll 12
        for (int r = 0; r < N; ++r) add_product(sum[r % SUMS], conj(v[r]), M[j][I + r]);
        for (int k = 1; k < SUMS; ++k) sum[0] += sum[k];
        const V f = -scaled(w, sum[0]);
#pragma GCC unroll 12
        for (int r = 0; r < N; ++r) add_product(M[j][I + r], f, v[r]);
    }
}

// Makes several blocks of matrices upper triangular in step: the square roots of one wait while another is reflected.
template <int K, class V, int I = 0> STEP void make_triangular(V (&M)[K][SIZE][SIZE]) {
    if constexpr (IS_CALLED<V>) {
        for (int i = 0; i < SIZE - 1; ++i) reflect(M[0], i);
    } else if constexpr (I < SIZE - 1) {
#pragma GCC unroll 1
        for (int k = 0; k < K; ++k) reflect(M[k], I);
        make_triangular<K, V, I + 1>(M);
    }
}

// ---- samples -------------------------------------------------------------------------------------------------------

// Cosine of k half turns over SAMPLES, and what its rounding leaves out.
struct SampleCosine {
    double rounded, rest;
};
constexpr SampleCosine sample_cosine(int k) {
    constexpr SampleCosine quarter[SAMPLES / 2 + 1] = {{1.0, 0.0},
                                                       {0.9914448613738104, 2.898989874454537e-17},
                                                       {0.9659258262890683, -2.5463971562308955e-17},
                                                       {0.9238795325112867, 1.7645047084336677e-17},
                                                       {0.8660254037844386, 5.0175421109034514e-17},
                                                       {0.7933533402912352, -5.028625073907125e-19},
                                                       {0.7071067811865476, -4.833646656726457e-17},
                                                       {0.6087614290087207, -1.647047979025087e-17},
                                                       {0.5, 0.0},
                                                       {0.3826834323650898, -1.0050772696461588e-17},
                                                       {0.25881904510252074, 2.287249500495561e-17},
                                                       {0.1305261922200516, -9.607666023901524e-18},
                                                       {0.0, 0.0}};
    k = (k % (2 * SAMPLES) + 2 * SAMPLES) % (2 * SAMPLES);
    k = k > SAMPLES ? 2 * SAMPLES - k : k;
    if (k <= SAMPLES / 2) return quarter[k];
    return {-quarter[SAMPLES - k].rounded, -quarter[SAMPLES - k].rest};
}
constexpr SampleCosine sample_sine(int k) { return sample_cosine(k - SAMPLES / 2); }

// Cosines and sines of (sample times harmonic), harmonics side by side. Samples stand half way between the multiples of 15 degrees,
// where solutions of poses with round numbers are.
inline constexpr int HARMONICS = 16;
struct Waves {
    double c[SAMPLES][HARMONICS], s[SAMPLES][HARMONICS], c_rest[SAMPLES][HARMONICS], s_rest[SAMPLES][HARMONICS];
    constexpr Waves() : c(), s(), c_rest(), s_rest() {
        for (int k = 0; k < SAMPLES; ++k) {
            for (int h = 0; h < HARMONICS; ++h) {
                const SampleCosine cosine = sample_cosine((2 * k + 1) * h), sine = sample_sine((2 * k + 1) * h);
                c[k][h] = cosine.rounded, s[k][h] = sine.rounded, c_rest[k][h] = cosine.rest, s_rest[k][h] = sine.rest;
            }
        }
    }
};
inline constexpr Waves WAVES;

// Rounding of a matrix from its coefficients, and of a reflection, as shares of the Frobenius norm of what is reflected, in units:
// w |v|^2 = 2, v is off by 8 u |v| and w by 14 u w, 60 u; a product in two sums of six terms 16 u, its subtraction 4 u.
inline constexpr double ROUNDING_OF_MATRIX = 10.0, ROUNDING_OF_REFLECTION = 86.0;

// Adds the squares of column k of the inverse; over: one over the diagonal. Each known entry is taken from all rows above.
template <class V> STEP void add_column_of_inverse(int k, const V (&R)[SIZE][SIZE], const V (&over)[SIZE], Block& square) {
    V x[SIZE];
    x[k] = over[k];
#pragma GCC unroll 12
    for (int i = 0; i < k; ++i) x[i] = -R[k][i] * x[k];
    square += leading(x[k]) * leading(x[k]);
#pragma GCC unroll 12
    for (int i = k - 1; i >= 0; --i) {
        x[i] = over[i] * x[i], square += leading(x[i]) * leading(x[i]);
#pragma GCC unroll 12
        for (int j = 0; j < i; ++j) add_product(x[j], -R[i][j], x[i]);
    }
}

// A bound on what changing each matrix by at most `inexact` and rounding by `unit` may do to its determinant D, R being the
// triangular factors: det(M + E) = D det(1 + M^-1 E), and |det(1 + X) - 1| <= e^x - 1 with the sum x of the singular values of X,
// which is at most |M^-1| |E| in Frobenius norms. Infinite where x exceeds a half.
template <class V> STEP Block determinant_error(const V (&R)[SIZE][SIZE], const Block& D, double inexact, double unit) {
    Block inverse = 0.0, below = 0.0, rounding = 0.0;
    V over[SIZE];
    for (int i = SIZE - 1; i >= 0; --i) {
        over[i] = 1.0 / R[i][i];
        for (int j = i; j < SIZE; ++j) below += leading(R[j][i]) * leading(R[j][i]);
        // Rows i to 11 have the norm of what reflection i turns.
        if (i < SIZE - 1) rounding += unit * ROUNDING_OF_REFLECTION * sqrt(below);
    }
    rounding += unit * ROUNDING_OF_MATRIX * sqrt(below);
    if constexpr (std::is_same_v<V, Block>) {
        in_turn<0, SIZE>([&](auto k) IN_PLACE { add_column_of_inverse(k, R, over, inverse); });
    } else {
#pragma GCC unroll 1
        for (int k = 0; k < SIZE; ++k) add_column_of_inverse(k, R, over, inverse);
    }
    const Block x = sqrt(inverse) * (inexact + rounding);
    return select(x < Block(0.5), abs(D) * (1.3 * x), Block(__builtin_inf()));
}

// The determinants at the samples. error: the sum of the bounds on what `inexact` (see determinant_error) and rounding may do to
// them, and to sums of 24 of their products with waves.
template <class V, class E, class Real> PART void determinants(const E& A, Real (&D)[SAMPLES], double inexact, double& error) {
    constexpr bool doubled = !std::is_same_v<V, Block>;
    const double unit = doubled ? DOUBLED_UNIT : UNIT;
    // Of doubled numbers several matrices would not fit in the cache.
    constexpr int K = doubled ? 1 : GROUPS;
    Block off = 0.0;
    V M[K][SIZE][SIZE];
    for (int g = 0; g < GROUPS; ++g) {
        const auto wave = [&](const auto& rounded, const auto& rest) {
            double a[BLOCK], b[BLOCK];
            for (int l = 0; l < BLOCK; ++l) a[l] = rounded[BLOCK * g + l][1], b[l] = rest[BLOCK * g + l][1];
            if constexpr (doubled) return load_doubled(a, b);
            else return load<Block>(a);
        };
        matrix_at(A, wave(WAVES.c, WAVES.c_rest), wave(WAVES.s, WAVES.s_rest), M[g % K]);
        if (g % K < K - 1) continue;
        make_triangular(M);
        for (int k = 0; k < K; ++k) {
            // Each of the eleven reflections turns the determinant's sign.
            V product = -M[k][0][0];
            for (int i = 1; i < SIZE; ++i) product = product * M[k][i][i];
            store(product, D + BLOCK * (g - K + 1 + k));
            off += determinant_error(M[k], leading(product), inexact, unit) + 32.0 * unit * abs(leading(product));
        }
    }
    error = 0.0;
    for (int l = 0; l < BLOCK; ++l) error += off[l];
}

// Fourier coefficients -8 to 8 of the samples. Returns the noise of the determinant: the largest of the harmonics 9 to
// 11, which rounding alone makes nonzero, over the largest of the others.
STEP double harmonics(const double (&D)[SAMPLES], Complex (&c)[2 * DEGREE + 1]) {
    double re[HARMONICS], im[HARMONICS];
    for (int b = 0; b < HARMONICS; b += BLOCK) {
        Block x = 0.0, y = 0.0;
        for (int k = 0; k < SAMPLES; ++k) x += D[k] * load<Block>(WAVES.c[k] + b), y -= D[k] * load<Block>(WAVES.s[k] + b);
        store(x, re + b), store(y, im + b);
    }
    double largest = 0.0, noise = 0.0;
    for (int h = 0; h < SAMPLES / 2; ++h) {
        const double square = re[h] * re[h] + im[h] * im[h];
        if (h <= DEGREE) {
            c[DEGREE + h] = {re[h], im[h]}, c[DEGREE - h] = {re[h], -im[h]};
            largest = max(square, largest);
        } else {
            noise = max(square, noise);
        }
    }
    return largest > 0.0 ? sqrt(noise / largest) : __builtin_inf();
}

STEP Block inverse(const Block& a) { return 1.0 / a; }

// Nearly null vectors of the matrices at the hidden turns t: inverse iteration on R* R. halves: (1, cos, sin) of joint a + 3,
// slowest, times the cosine and the sine of half of joint a + 4 and of three halves.
template <class V> PART void null_vectors(const Equations& A, const Turn<V>& t, V (&halves)[SIZE]) {
    V M[1][SIZE][SIZE], w[SIZE], x[SIZE];
    Block longest = 0.0;
    matrix_at(A, t.c, t.s, M[0]);
    make_triangular(M);
    const auto& R = M[0];
    for (int i = 0; i < SIZE; ++i) longest = max(longest, above(R[i][i]));
    const Block least = 1e-15 * longest + TINY;
    for (int i = 0; i < SIZE; ++i) {
        w[i] = inverse(select(above(R[i][i]) > least, R[i][i], scaled(least, V(1.0))));
        x[i] = 1.0 + 0.1 * i * ((i % 3) - 1);
    }
    for (int round = 0; round < 2; ++round) {
        for (int i = 0; i < SIZE; ++i) {
            for (int j = 0; j < i; ++j) x[i] = x[i] - conj(R[i][j]) * x[j];
            x[i] = conj(w[i]) * x[i];
        }
        Block all = TINY;
        for (int i = SIZE - 1; i >= 0; --i) {
            for (int j = i + 1; j < SIZE; ++j) x[i] = x[i] - R[j][i] * x[j];
            x[i] = w[i] * x[i];
            all += square(x[i]);
        }
        const Block length = 1.0 / sqrt(all);
        for (auto& each : x) each = scaled(length, each);
    }
    // C = C^3 + C S^2 and S = S^3 + C^2 S; the cosine and the sine of three halves are C^3 - 3 C S^2 and 3 C^2 S - S^3.
    for (int j = 0; j < 3; ++j) {
        const V cosine = x[j] + x[j], sine = x[3 + j] + x[3 + j];
        halves[4 * j] = cosine + x[9 + j], halves[4 * j + 1] = sine + x[6 + j];
        halves[4 * j + 2] = cosine - 3.0 * x[9 + j], halves[4 * j + 3] = 3.0 * x[6 + j] - sine;
    }
}

// ---- the other joints ------------------------------------------------------------------------------------------------

// A joint's value: an angle, or a length in the scaled frame.
template <class V> struct Value {
    Turn<V> turn;
    V length;
};

// The point v, moved backwards by joint j of the loop.
template <class V> STEP Vec<V> undone(const EliminationVariant& at, int j, const Value<V>& value, const Vec<V>& v) {
    const Vec<V> h = vec<V>(at.axes[j]);
    if (at.slides[j]) return v - value.length * h;
    const Vec<V> p = vec<V>(at.points[j]), x = v - p;
    return value.turn.c * x - value.turn.s * cross(h, x) + ((1.0 - value.turn.c) * dot(h, x)) * h + p;
}

// The point v, moved backwards through joints a + 3, a + 4, a + 5, and by G at its place among them.
template <class V> STEP Vec<V> other_side(const EliminationVariant& at, const Frame<V>& G, const Value<V> (&values)[6], Vec<V> v) {
    for (int k = 0; k < 4; ++k) {
        if (k + at.first == 3) v = G.R * v + G.p;
        const int j = (at.first + 3 + k) % 6;
        if (k < 3) v = undone(at, j, values[j], v);
    }
    return v;
}

// Joints a, a + 1 and a + 2 from the others: the line of joint a + 2, moved through the other side, gives the products of joints a
// and a + 1; joint a + 2 turns a vector across its axis to the direction that the other side gives. value_of(joint, c, s): its
// value from multiples of its cosine and sine.
template <class V, class F>
STEP void add_first_values(const EliminationVariant& at, const Frame<V>& G, Value<V> (&values)[6], const F& value_of) {
    const int first = at.first, k = first + 2;
    const Vec<V> axis = vec<V>(at.axes[k]), start = vec<V>(at.points[k]), across = vec<V>(at.across);
    const Vec<V> p = other_side(at, G, values, start), l = other_side(at, G, values, start + axis) - p, m = cross(p, l);
    const V h = 0.5 * dot(p, p), along = dot(p, l);
    const Vec<V> rest = h * l - along * p;
    const V w[LINE] = {V(1.0), p.x, p.y, p.z, h, l.x, l.y, l.z, m.x, m.y, m.z, along, rest.x, rest.y, rest.z};
    const auto product = [&](int i) {
        V sum = 0.0;
        for (int j = 0; j < LINE; ++j) sum += at.left_inverse[i][j] * w[j];
        return sum;
    };
    values[first] = value_of(first, product(3), product(6));
    values[first + 1] = value_of(first + 1, product(1), product(2));
    Vec<V> v = other_side(at, G, values, start + across);
    v = undone(at, first, values[first], v);
    v = undone(at, first + 1, values[first + 1], v) - start;
    values[k] = value_of(k, dot(across, v), dot(axis, cross(across, v)));
}

// The values of all joints of the loop for hidden angles (c, s), from the null vectors of their matrices.
PART void remaining_values(const EliminationVariant& at, const Frame<double>& motion, const Block (&x)[SIZE], const Block& c,
                           const Block& s, Block (&q)[6]) {
    const Frame<Block> G = spread<Block>(motion);
    const int kept = (at.first + 3) % 6, kept_too = (at.first + 4) % 6, hidden = (at.first + 5) % 6;
    Value<Block> values[6];
    // The null vector is (1, cos, sin) of joint a + 3 times a vector of the halves. Take the longest of these three
    // copies.
    Block longest = x[0] * x[0] + x[1] * x[1], halves[4] = {x[0], x[1], x[2], x[3]};
    for (int j = 1; j < 3; ++j) {
        const Block square = x[4 * j] * x[4 * j] + x[4 * j + 1] * x[4 * j + 1];
        const auto longer = square > longest;
        longest = select(longer, square, longest);
        for (int i = 0; i < 4; ++i) halves[i] = select(longer, x[4 * j + i], halves[i]);
    }
    Block d[3] = {0.0, 0.0, 0.0};
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 3; ++j) d[j] += x[4 * j + i] * halves[i];
    }
    const Block sign = select(d[0] > Block(0.0), Block(1.0), -1.0);
    values[kept].turn = unit<Block>(sign * d[1], sign * d[2]);
    values[kept].length = values[kept].turn.s / (1.0 + values[kept].turn.c);
    const Turn<Block> half = unit(halves[0], halves[1]);
    values[kept_too] = {{half.c * half.c - half.s * half.s, 2.0 * half.c * half.s}, half.s / half.c};
    values[hidden] = {{c, s}, s / (1.0 + c)};
    add_first_values(at, G, values,
                     [](int, const Block& cosine, const Block& sine) { return Value<Block>{unit(cosine, sine), cosine}; });
    for (int j = 0; j < 6; ++j) {
        const int from = at.reversed ? 5 - j : j;
        q[j] = at.slides[from] ? values[from].length : wrap(angle(values[from].turn));
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
