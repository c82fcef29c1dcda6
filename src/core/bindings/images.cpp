// Bindings for the images of joint vectors inside the limits.
#include "propose/images.hpp"

#include <cstdint>
#include <vector>

#include "bindings/module.hpp"
#include "bindings/numpy_api.hpp"
#include "bindings/signals.hpp"

namespace urdf_ik {

namespace {

// Joint vectors (..., n), and the limits of their joints.
struct Vectors {
    PyArrayObject* array;
    const double* q;
    long count;
    std::vector<Limit> limits;

    Vectors(nb::handle vectors, nb::handle bounds, nb::handle turns) : array(needed(vectors)) {
        PyArrayObject *sides = needed(bounds), *apart = needed(turns);
        const long n = PyArray_SIZE(apart), last = PyArray_NDIM(array) - 1;
        if (last < 0 || PyArray_DIM(array, last) != n || PyArray_SIZE(sides) != 2 * n) {
            throw nb::value_error("joint vectors and limits do not fit each other");
        }
        q = (const double*)PyArray_DATA(array);
        const double *side = (const double*)PyArray_DATA(sides), *turn = (const double*)PyArray_DATA(apart);
        for (long j = 0; j < n; ++j) limits.emplace_back(side[2 * j], side[2 * j + 1], turn[j]);
        count = n ? PyArray_SIZE(array) / n : PyArray_MultiplyList(PyArray_DIMS(array), last);
    }
    static PyArrayObject* needed(nb::handle numbers) {
        PyArrayObject* found = doubles(numbers);
        if (!found) throw nb::type_error("an array of float64 in C order is needed");
        return found;
    }
    int joints() const { return int(limits.size()); }
    // A new array: (..., n) of numbers, or (...) of booleans.
    template <class T> nb::object made(T*& to) const {
        const bool truth = sizeof(T) == 1;
        return new_array(PyArray_NDIM(array) - truth, PyArray_DIMS(array), truth ? NPY_BOOL : NPY_DOUBLE, to);
    }
    // Calls work(i) for every vector.
    template <class Work> void each(const Work& work) const {
        in_parts(count, [&](long first, long many) {
            for (long i = first; i < first + many; ++i) work(i);
        });
    }
    // Calls image(vector, joint, to) for every value. A vector is NaN if one of its joints has no image.
    template <class Image> nb::tuple moved(const Image& image) const {
        double* to;
        std::uint8_t* inside;
        nb::object images = made(to), has = made(inside);
        const int n = joints();
        each([&](long i) {
            bool all = true;
            for (int j = 0; j < n && all; ++j) all = image(i, j, to[i * n + j]);
            if (!all) std::fill_n(to + i * n, n, NAN);
            inside[i] = all;
        });
        return nb::make_tuple(images, has);
    }
};

nb::tuple ranges(nb::handle q, nb::handle bounds, nb::handle turns) {
    const Vectors given(q, bounds, turns);
    double *first, *last;
    nb::object from = given.made(first), to = given.made(last);
    const int n = given.joints();
    given.each([&](long i) {
        for (int j = 0; j < n; ++j) {
            const ImageRange range = image_range(given.q[i * n + j], given.limits[j]);
            first[i * n + j] = range.first, last[i * n + j] = range.last;
        }
    });
    return nb::make_tuple(from, to);
}

nb::tuple nearest(nb::handle q, nb::handle bounds, nb::handle turns) {
    const Vectors given(q, bounds, turns);
    const int n = given.joints();
    return given.moved([&](long i, int j, double& image) { return nearest_image(given.q[i * n + j], given.limits[j], image); });
}

// The images nearest to references: one for all vectors, or one for each group of `each` consecutive vectors.
nb::tuple near(nb::handle q, nb::handle q_ref, nb::handle bounds, nb::handle turns) {
    const Vectors given(q, bounds, turns);
    PyArrayObject* array = Vectors::needed(q_ref);
    const int n = given.joints();
    const long references = n ? PyArray_SIZE(array) / n : 1;
    if (references * n != PyArray_SIZE(array) || given.count % std::max(1L, references) || (references < 1 && given.count)) {
        throw nb::value_error("joint vectors and references do not fit each other");
    }
    const long each = std::max(1L, given.count / std::max(1L, references));
    const double* reference = (const double*)PyArray_DATA(array);
    return given.moved([&](long i, int j, double& image) {
        return image_near(given.q[i * n + j], reference[i / each * n + j], given.limits[j], image);
    });
}

// For each vector: whether it is selected and has an image inside.
nb::object inside(nb::handle q, nb::handle asked, nb::handle bounds, nb::handle turns) {
    const Vectors given(q, bounds, turns);
    PyArrayObject* mask = (PyArrayObject*)asked.ptr();
    if (!PyArray_CheckExact(asked.ptr()) || PyArray_TYPE(mask) != NPY_BOOL || !PyArray_ISCARRAY_RO(mask) ||
        PyArray_SIZE(mask) != given.count) {
        throw nb::type_error("a truth value for each joint vector is needed");
    }
    const std::uint8_t* among = (const std::uint8_t*)PyArray_DATA(mask);
    std::uint8_t* out;
    nb::object has = given.made(out);
    const int n = given.joints();
    given.each([&](long i) {
        bool all = among[i];
        for (int j = 0; j < n && all; ++j) all = has_image(given.q[i * n + j], given.limits[j]);
        out[i] = all;
    });
    return has;
}

}  // namespace

void bind_images(nb::module_& m) {
    m.def("image_range", &ranges, nb::arg("q"), nb::arg("bounds"), nb::arg("turns"),
          "Turns to the first and the last image inside the bounds: two arrays like q (..., n).");
    m.def("nearest_image", &nearest, nb::arg("q"), nb::arg("bounds"), nb::arg("turns"),
          "Images (..., n) inside the bounds, fewest turns away, and which (...) there are.");
    m.def("image_near", &near, nb::arg("q"), nb::arg("q_ref"), nb::arg("bounds"), nb::arg("turns"),
          "Images (..., n) inside the bounds, nearest to q_ref (n,) or (..., n), and which (...) there are.");
    m.def("has_image", &inside, nb::arg("q"), nb::arg("among"), nb::arg("bounds"), nb::arg("turns"),
          "Which (...) of the joint vectors (..., n) among those that are asked about have an image inside the bounds.");
}

}  // namespace urdf_ik
