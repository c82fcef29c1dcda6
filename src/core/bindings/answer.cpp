// See answer.hpp. This uses the C-APIs of Python and NumPy: a call through nanobind's typed arrays takes several times as long as a
// solve.
#include "bindings/answer.hpp"

#include <cstddef>
#include <cstdlib>
#include <cstring>

#define URDF_IK_IMPORTS_NUMPY
#include "bindings/numpy_api.hpp"
#include "bindings/sharing.hpp"

#include <structmember.h>

namespace urdf_ik {

namespace {

// numbers: for a single pose, 16 of the target, then the joint vectors, then a byte of flags for each joint vector; null for a
// batch, whose three arrays are set.
struct Answer {
    PyObject_HEAD PyObject *solver, *branches, *origin, *step, *redundancy;
    PyObject *poses, *q, *info;  // arrays; null: not used yet
    double* numbers;
    npy_intp columns, joints;
};

PyTypeObject* answer_type = nullptr;  // set when the module is imported

constexpr long TARGET = 16;

PyObject* filled(int dimensions, const npy_intp* shape, int type, const void* from) {
    PyObject* array = PyArray_SimpleNew(dimensions, shape, type);
    if (array) std::memcpy(PyArray_DATA((PyArrayObject*)array), from, PyArray_NBYTES((PyArrayObject*)array));
    return array;
}

// The array in one of the three fields, made from the numbers at its first use.
PyObject* array_of(Answer* self, PyObject*& field) {
    if (!field && self->numbers) {
        const npy_intp poses[2] = {4, 4}, q[2] = {self->columns, self->joints};
        const double* vectors = self->numbers + TARGET;
        if (&field == &self->poses) field = filled(2, poses, NPY_DOUBLE, self->numbers);
        else if (&field == &self->q) field = filled(2, q, NPY_DOUBLE, vectors);
        else field = filled(1, q, NPY_UINT8, vectors + self->columns * self->joints);
        if (!field) return nullptr;
    }
    return Py_NewRef(field ? field : Py_None);
}

template <PyObject* Answer::* field> PyObject* get(PyObject* self, void*) {
    return array_of((Answer*)self, ((Answer*)self)->*field);
}
template <PyObject* Answer::* field> int set(PyObject* self, PyObject* value, void*) {
    Py_XSETREF(((Answer*)self)->*field, Py_XNewRef(value));
    return 0;
}

constexpr PyObject* Answer::* FIELDS[] = {&Answer::solver,     &Answer::branches, &Answer::origin, &Answer::step,
                                          &Answer::redundancy, &Answer::poses,    &Answer::q,      &Answer::info};

int traverse(PyObject* object, visitproc visit, void* arg) {
    for (const auto field : FIELDS) Py_VISIT(((Answer*)object)->*field);
    Py_VISIT(Py_TYPE(object));
    return 0;
}

int clear(PyObject* object) {
    for (const auto field : FIELDS) Py_CLEAR(((Answer*)object)->*field);
    return 0;
}

void destroy(PyObject* object) {
    PyTypeObject* type = Py_TYPE(object);
    PyObject_GC_UnTrack(object);
    clear(object);
    std::free(((Answer*)object)->numbers);
    type->tp_free(object);
    Py_DECREF(type);
}

// What callers read: the joint vectors, read-only.
PyObject* get_q(PyObject* self, void*) {
    PyObject* q = array_of((Answer*)self, ((Answer*)self)->q);
    if (q && PyArray_Check(q)) PyArray_CLEARFLAGS((PyArrayObject*)q, NPY_ARRAY_WRITEABLE);
    return q;
}

PyMemberDef members[] = {
    {"solver", T_OBJECT, offsetof(Answer, solver), 0, "The solver that made them."},
    {"_branches", T_OBJECT, offsetof(Answer, branches), 0, nullptr},
    {"_origin", T_OBJECT, offsetof(Answer, origin), 0, nullptr},
    {"step", T_OBJECT, offsetof(Answer, step), 0, "How they were made from other solutions; None: solved."},
    {"_redundancy", T_OBJECT, offsetof(Answer, redundancy), 0, nullptr},
    {nullptr, 0, 0, 0, nullptr},
};
PyGetSetDef arrays[] = {
    {"_poses", get<&Answer::poses>, set<&Answer::poses>, nullptr, nullptr},
    {"_q", get<&Answer::q>, set<&Answer::q>, nullptr, nullptr},
    {"_info", get<&Answer::info>, set<&Answer::info>, nullptr, nullptr},
    {"_read_only_q", get_q, nullptr,
     "(..., B, n) rad or m, NaN where there is no solution; angles in (-pi, pi] as the solver gives them.", nullptr},
    {nullptr, nullptr, nullptr, nullptr, nullptr},
};
PyType_Slot slots[] = {
    {Py_tp_new, (void*)PyType_GenericNew},
    {Py_tp_dealloc, (void*)destroy},
    {Py_tp_traverse, (void*)traverse},
    {Py_tp_clear, (void*)clear},
    {Py_tp_members, members},
    {Py_tp_getset, arrays},
    {Py_tp_doc, (void*)"The numbers of solutions; arrays are made when they are asked for."},
    {0, nullptr},
};
PyType_Spec spec = {"urdf_ik._core.Answer", sizeof(Answer), 0, Py_TPFLAGS_DEFAULT | Py_TPFLAGS_BASETYPE | Py_TPFLAGS_HAVE_GC,
                    slots};

// A new object of the Python class `kind`, which is derived from Answer.
nb::object make(nb::handle kind, nb::handle owner, nb::handle branches) {
    PyTypeObject* type = (PyTypeObject*)kind.ptr();
    if (!PyType_Check(kind.ptr()) || !PyType_IsSubtype(type, answer_type))
        throw nb::type_error("a class derived from Answer is needed");
    nb::object made = nb::steal(type->tp_alloc(type, 0));
    if (!made.is_valid()) throw nb::python_error();
    Answer* self = (Answer*)made.ptr();
    self->solver = Py_NewRef(owner.ptr()), self->branches = Py_NewRef(branches.ptr());
    return made;
}

// An array of doubles that begins at a cache line: stores across cache lines cost a batch half of its speed.
PyObject* at_a_cache_line(int dimensions, const npy_intp* shape) {
    constexpr npy_intp LINE = 64;
    const npy_intp bytes = 8 * PyArray_MultiplyList(shape, dimensions) + LINE;
    PyObject* whole = PyArray_SimpleNew(1, &bytes, NPY_UINT8);
    if (!whole) return nullptr;
    char* start = PyArray_BYTES((PyArrayObject*)whole);
    start += -reinterpret_cast<std::uintptr_t>(start) % LINE;
    PyObject* array = PyArray_New(&PyArray_Type, dimensions, shape, NPY_DOUBLE, nullptr, start, 0, NPY_ARRAY_CARRAY, nullptr);
    if (!array || PyArray_SetBaseObject((PyArrayObject*)array, whole) < 0) {
        if (!array) Py_DECREF(whole);
        Py_XDECREF(array);
        return nullptr;
    }
    return array;
}

// Whether the object is a C-ordered array of this type and shape.
bool is_array(PyObject* object, int type, int dimensions, const npy_intp* shape) {
    if (!object || !PyArray_CheckExact(object)) return false;
    PyArrayObject* array = (PyArrayObject*)object;
    return PyArray_TYPE(array) == type && PyArray_ISCARRAY_RO(array) && PyArray_NDIM(array) == dimensions &&
           PyArray_CompareLists(PyArray_DIMS(array), shape, dimensions);
}

// The numbers of the object if it is a C-ordered float64 array of this shape, else null.
template <int D> const double* numbers_of(nb::handle object, const npy_intp (&shape)[D]) {
    return is_array(object.ptr(), NPY_DOUBLE, D, shape) ? (const double*)PyArray_DATA((PyArrayObject*)object.ptr()) : nullptr;
}

}  // namespace

nb::object solve_one(const PySolver& of, nb::handle kind, nb::handle owner, nb::handle branches, nb::handle T, nb::handle q_ref) {
    const Solver& solver = *of.solver;
    const double* target = numbers_of(T, {4, 4});
    const double* reference = q_ref.is_none() ? nullptr : numbers_of(q_ref, {solver.joints});
    if (!target || solver.numbers != TARGET || (!reference && !q_ref.is_none())) return nb::none();
    const long columns = solver.branches, joints = solver.joints, count = columns * joints;
    nb::object made = make(kind, owner, branches);
    Answer* self = (Answer*)made.ptr();
    self->numbers = (double*)std::malloc(8 * (TARGET + count) + columns);
    if (!self->numbers) throw std::bad_alloc();
    self->columns = columns, self->joints = joints;
    std::memcpy(self->numbers, target, 8 * TARGET);
    double* q = self->numbers + TARGET;
    const Batch batch = {self->numbers, 1, reference, nullptr, q, (std::uint8_t*)(q + count)};
    return solver.solve(batch) < 0 ? made : nb::none();
}

nb::object solve_many(const PySolver& of, nb::handle kind, nb::handle owner, nb::handle branches, nb::handle T, nb::handle q_ref,
                      nb::handle values, int threads, nb::handle out) {
    constexpr int MOST = 32;  // dimensions
    const Solver& solver = *of.solver;
    const PyArrayObject* targets = doubles(T);
    if (!targets) return nb::none();
    const npy_intp* given = PyArray_DIMS(targets);
    const bool poses = solver.numbers == TARGET;
    const int batch_dimensions = PyArray_NDIM(targets) - (poses ? 2 : 1);
    if (batch_dimensions < 0 || batch_dimensions > MOST) return nb::none();
    npy_intp shape[MOST + 2], m = 1;
    for (int i = 0; i < batch_dimensions; ++i) shape[i] = given[i], m *= given[i];
    const npy_intp* numbers = given + batch_dimensions;
    if (poses ? numbers[0] != 4 || numbers[1] != 4 : numbers[0] != solver.numbers) return nb::none();
    shape[batch_dimensions] = solver.branches, shape[batch_dimensions + 1] = solver.joints;
    const double* reference = q_ref.is_none() ? nullptr : numbers_of(q_ref, {solver.joints});
    const double* parameters = nullptr;
    if (!values.is_none()) {
        const PyArrayObject* array = doubles(values);
        if (array && PyArray_SIZE(array) == m * solver.parameters) parameters = (const double*)PyArray_DATA(array);
    }
    if ((!reference && !q_ref.is_none()) || (!parameters && !values.is_none())) return nb::none();

    nb::object made;
    if (out.is_none()) {
        made = make(kind, owner, branches);
        Answer* self = (Answer*)made.ptr();
        self->q = at_a_cache_line(batch_dimensions + 2, shape);
        self->info = PyArray_SimpleNew(batch_dimensions + 1, shape, NPY_UINT8);
        if (!self->q || !self->info) throw nb::python_error();
    } else {
        made = nb::borrow(out);
        Answer* self = (Answer*)made.ptr();
        if (!PyObject_TypeCheck(out.ptr(), answer_type) || !is_array(self->q, NPY_DOUBLE, batch_dimensions + 2, shape) ||
            !is_array(self->info, NPY_UINT8, batch_dimensions + 1, shape)) {
            return nb::none();
        }
    }
    Answer* self = (Answer*)made.ptr();
    Py_XSETREF(self->poses, Py_NewRef(T.ptr()));
    Py_XSETREF(self->redundancy, values.is_none() ? nullptr : Py_NewRef(values.ptr()));
    const Batch batch = {(const double*)PyArray_DATA(targets),
                         m,
                         reference,
                         parameters,
                         (double*)PyArray_DATA((PyArrayObject*)self->q),
                         (std::uint8_t*)PyArray_DATA((PyArrayObject*)self->info)};
    const long bad = without_gil([&](const Stop& stop) { return solve_shared(solver, batch, threads, stop); });
    return bad < 0 ? made : nb::none();
}

void bind_answer(nb::module_& m) {
    if (_import_array() < 0) throw nb::python_error();
    answer_type = (PyTypeObject*)PyType_FromSpec(&spec);
    if (!answer_type) throw nb::python_error();
    m.attr("Answer") = nb::borrow((PyObject*)answer_type);
}

}  // namespace urdf_ik
