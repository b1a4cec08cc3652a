/* The core in Python, through CPython's stable interface: `jounce.core.binding`.
 *
 * Arrays come as buffers of doubles, results are numpy's arrays. Plain numbers, tuples and lists
 * are read at once; for anything else TypeError is raised, for numbers out of place ValueError,
 * and the caller in Python converts, or says what is wrong. No state but the module's, so that
 * threads and interpreters do not meet; long work is done without the interpreter's lock.
 */
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <stdlib.h>
#include <string.h>

#include "binding_fmi2.h"
#include "jounce.h"

enum { LONG = 2048 }; /* points from which other threads may run meanwhile */

typedef struct {
    PyObject *empty, *asarray, *ndarray, *number; /* numpy's; the last one float64 */
    PyObject *convert;                             /* {"order": "C"} */
    PyObject *pieces, *motion, *follower;          /* types */
    PyObject *of_motion, *of_coasting, *of_limits, *of_inside_after, *of_flat; /* attributes */
} State;

#define FAST(function) ((PyCFunction)(void (*)(void))(function))

static State *state_of(PyObject *self) { return PyType_GetModuleState(Py_TYPE(self)); }

/* Objects hold on to their type. */
static void let_go(PyObject *self) {
    PyTypeObject *type = Py_TYPE(self);
    freefunc release_memory = (freefunc)PyType_GetSlot(type, Py_tp_free);
    release_memory(self);
    Py_DECREF(type);
}

static int expect_or(Py_ssize_t given, Py_ssize_t count, Py_ssize_t or_count,
                     const char *signature) {
    if (given == count || given == or_count) {
        return 1;
    }
    PyErr_Format(PyExc_TypeError, "%s: got %zd arguments", signature, given);
    return 0;
}

static int expect(Py_ssize_t given, Py_ssize_t count, const char *signature) {
    return expect_or(given, count, count, signature);
}

/* --- buffers ---------------------------------------------------------------------------------- */

enum { READ = PyBUF_C_CONTIGUOUS | PyBUF_FORMAT, WRITE = READ | PyBUF_WRITABLE };

static int of_doubles(const Py_buffer *view) {
    return view->itemsize == (Py_ssize_t)sizeof(double) && strcmp(view->format, "d") == 0;
}

static Py_ssize_t items(const Py_buffer *view) { return view->len / view->itemsize; }

/* Look into an array of doubles; 0 with TypeError for anything else. */
static int look(PyObject *object, Py_buffer *view, int flags) {
    if (PyObject_GetBuffer(object, view, flags) == 0) {
        if (of_doubles(view)) {
            return 1;
        }
        PyBuffer_Release(view);
    }
    PyErr_SetString(PyExc_TypeError, "expected a contiguous array of float64");
    return 0;
}

typedef struct {
    PyObject *object;
    Py_ssize_t size; /* of an item; 8 means a double, 1 a signed byte */
    Py_ssize_t count, or_count;
    int flags;
} Wanted;

static void release(Py_buffer *views, int count) {
    while (count > 0) {
        PyBuffer_Release(&views[--count]);
    }
}

/* Look into arrays that must have `count` or `or_count` items. */
static int look_into(const Wanted *wanted, int count, Py_buffer *views) {
    int i;
    for (i = 0; i < count; i++) {
        const Wanted *w = &wanted[i];
        if (PyObject_GetBuffer(w->object, &views[i], w->flags) < 0) {
            release(views, i);
            return 0;
        }
        if (views[i].itemsize != w->size ||
            strcmp(views[i].format, w->size == 1 ? "b" : "d") != 0) {
            PyErr_Format(PyExc_TypeError, "argument %d: expected a contiguous array of %s", i + 1,
                         w->size == 1 ? "int8" : "float64");
            release(views, i + 1);
            return 0;
        }
        if (items(&views[i]) != w->count && items(&views[i]) != w->or_count) {
            PyErr_Format(PyExc_ValueError, "argument %d has %zd values: expected %zd", i + 1,
                         items(&views[i]), w->count);
            release(views, i + 1);
            return 0;
        }
    }
    return 1;
}

static Wanted doubles(PyObject *object, Py_ssize_t count) {
    Wanted w = {object, 8, count, count, READ};
    return w;
}

static Wanted doubles_for_all(PyObject *object, Py_ssize_t each, Py_ssize_t count) {
    Wanted w = {object, 8, each * count, each, READ};
    return w;
}

static Wanted room(PyObject *object, Py_ssize_t count) {
    Wanted w = {object, 8, count, count, WRITE};
    return w;
}

static Wanted room_for_bytes(PyObject *object, Py_ssize_t count) {
    Wanted w = {object, 1, count, count, WRITE};
    return w;
}

/* A new array of the shape of `view`, after `rows` where those are not negative. */
static PyObject *new_array(State *state, Py_ssize_t rows, const Py_buffer *view) {
    int before = rows >= 0, i;
    PyObject *shape, *result;
    if (!before && view->ndim == 1) {
        shape = PyLong_FromSsize_t(view->shape[0]);
    } else {
        shape = PyTuple_New(before + view->ndim);
        if (shape != NULL && before) {
            PyTuple_SetItem(shape, 0, PyLong_FromSsize_t(rows));
        }
        for (i = 0; shape != NULL && i < view->ndim; i++) {
            PyTuple_SetItem(shape, before + i, PyLong_FromSsize_t(view->shape[i]));
        }
    }
    if (shape == NULL) {
        return NULL;
    }
    result = PyObject_CallFunctionObjArgs(state->empty, shape, NULL);
    Py_DECREF(shape);
    return result;
}

/* --- plain numbers ---------------------------------------------------------------------------- */

static int is_number(double x) { return x - x == 0.0; }

/* A float or int; 0 for anything else, without an error set. */
static int plain_number(PyObject *object, double *number) {
    if (!PyFloat_Check(object) && (!PyLong_Check(object) || PyBool_Check(object))) {
        return 0;
    }
    *number = PyFloat_AsDouble(object);
    if (*number == -1.0 && PyErr_Occurred()) {
        PyErr_Clear();
        return 0;
    }
    return 1;
}

/* The numbers in a tuple or list of up to `most`: how many, or -1 with TypeError. */
static Py_ssize_t plain_numbers(PyObject *object, double *numbers, Py_ssize_t most) {
    int is_tuple = PyTuple_Check(object);
    Py_ssize_t count = -1, i;
    if (is_tuple || PyList_Check(object)) {
        count = is_tuple ? PyTuple_Size(object) : PyList_Size(object);
    }
    for (i = 0; i < count && count <= most; i++) {
        PyObject *item = is_tuple ? PyTuple_GetItem(object, i) : PySequence_GetItem(object, i);
        int plain = item != NULL && plain_number(item, &numbers[i]);
        if (!is_tuple) { /* others may take it out of the list meanwhile */
            Py_XDECREF(item);
        }
        if (!plain) {
            break;
        }
    }
    if (count < 0 || i < count) {
        PyErr_Format(PyExc_TypeError, "expected a tuple or list of at most %zd numbers", most);
        return -1;
    }
    return count;
}

static int one_number(PyObject *object, double *number) {
    if (plain_number(object, number)) {
        return 1;
    }
    PyErr_SetString(PyExc_TypeError, "expected a float or int");
    return 0;
}

/* A state, or a position at rest. */
static int plain_state(PyObject *object, int order, jounce_state *state) {
    double values[3] = {0.0, 0.0, 0.0};
    Py_ssize_t count = plain_number(object, &values[0]) ? 1 : plain_numbers(object, values, order);
    if (count < 0) {
        return 0;
    }
    if (count == 0) {
        PyErr_SetString(PyExc_ValueError, "a state of no numbers");
        return 0;
    }
    if (!(is_number(values[0]) && is_number(values[1]) && is_number(values[2]))) {
        PyErr_SetString(PyExc_ValueError, "a state must be finite");
        return 0;
    }
    state->x = values[0];
    state->v = values[1];
    state->a = values[2];
    return 1;
}

/* Lower and upper bounds of 1 to 3 derivatives, velocity first. */
static jounce_limits limits_of(const double *bounds, int order) {
    jounce_limits limits;
    limits.v_low = bounds[0];
    limits.v_high = bounds[1];
    limits.a_low = order >= 2 ? bounds[2] : -Py_HUGE_VAL;
    limits.a_high = order >= 2 ? bounds[3] : Py_HUGE_VAL;
    limits.j_low = order == 3 ? bounds[4] : -Py_HUGE_VAL;
    limits.j_high = order == 3 ? bounds[5] : Py_HUGE_VAL;
    return limits;
}

/* Returns their order, at least `least`; 0 with an error set. */
static int plain_limits(PyObject *object, int least, jounce_limits *limits) {
    double bounds[6];
    Py_ssize_t count = plain_numbers(object, bounds, 6), i;
    int order = (int)(count / 2), sound = count % 2 == 0 && order >= least;
    for (i = 0; sound && i < count; i += 2) {
        sound = bounds[i] <= 0.0 && 0.0 <= bounds[i + 1] && bounds[i] < bounds[i + 1];
    }
    if (count < 0) {
        return 0;
    }
    if (!sound ||
        (order > 1 && (!is_number(bounds[count - 2]) || !is_number(bounds[count - 1])))) {
        PyErr_SetString(PyExc_ValueError,
                        "bounds: expected lower <= 0 <= upper of velocity, acceleration and, for "
                        "order 3, jerk, the last ones finite");
        return 0;
    }
    *limits = limits_of(bounds, order);
    return order;
}

/* --- Pieces: a function of time, ready to be evaluated ------------------------------------------ */

typedef struct {
    PyObject_HEAD
    jounce_pieces pieces;
    double *memory;
} Pieces;

/* Room for m pieces of order n: breaks, durations and states follow one another. */
static Pieces *new_pieces(PyTypeObject *type, size_t m, int n) {
    Pieces *self = (Pieces *)PyType_GenericNew(type, NULL, NULL);
    size_t width = (size_t)n + 1;
    if (self == NULL) {
        return NULL;
    }
    self->memory = PyMem_Calloc(2 * m + 1 + (m + 2) * width, sizeof(double));
    if (self->memory == NULL) {
        Py_DECREF(self);
        return (Pieces *)PyErr_NoMemory();
    }
    self->pieces.order = n;
    self->pieces.count = m;
    self->pieces.breaks = self->memory;
    self->pieces.durations = self->memory + m + 1;
    self->pieces.states = self->memory + 2 * m + 1;
    return self;
}

/* Copy a motion; outside, derivatives up to `coasting` go on from its first and last state. */
static void fill(const jounce_pieces *pieces, double *memory, const double *breaks,
                 const double *states, const double *durations, const double *end, int coasting) {
    size_t m = pieces->count, width = (size_t)pieces->order + 1;
    size_t known = (size_t)(coasting + 1) * sizeof(double);
    double *rows = memory + 2 * m + 1;
    memcpy(memory, breaks, (m + 1) * sizeof(double));
    if (m > 0) {
        memcpy(memory + m + 1, durations, m * sizeof(double));
        memcpy(rows + width, states, m * width * sizeof(double));
    }
    memcpy(rows, m > 0 ? states : end, known);
    memcpy(rows + (m + 1) * width, end, known);
}

static PyObject *pieces_new(PyTypeObject *type, PyObject *args, PyObject *names) {
    PyObject *breaks, *states, *durations, *end;
    Py_buffer views[4];
    Wanted wanted[4];
    Py_ssize_t m, width;
    int coasting;
    Pieces *self = NULL;
    if (names != NULL && PyDict_Size(names) > 0) {
        PyErr_SetString(PyExc_TypeError, "Pieces takes no keyword arguments");
        return NULL;
    }
    if (!PyArg_ParseTuple(args, "OOOOi:Pieces", &breaks, &states, &durations, &end, &coasting)) {
        return NULL;
    }
    m = PyObject_Size(durations);
    width = PyObject_Size(end);
    if (m < 0 || width < 0) {
        return NULL;
    }
    if (width < 2 || width > JOUNCE_MOST_ORDER + 1 || coasting < -1 || coasting >= width) {
        PyErr_Format(PyExc_ValueError, "end_state of %zd values, coasting = %d: expected 2 to %d, "
                     "and -1 to one less than the values", width, coasting, JOUNCE_MOST_ORDER + 1);
        return NULL;
    }
    wanted[0] = doubles(breaks, m + 1);
    wanted[1] = doubles(states, m * width);
    wanted[2] = doubles(durations, m);
    wanted[3] = doubles(end, width);
    if (!look_into(wanted, 4, views)) {
        return NULL;
    }
    self = new_pieces(type, (size_t)m, (int)width - 1);
    if (self != NULL) {
        fill(&self->pieces, self->memory, views[0].buf, views[1].buf, views[2].buf, views[3].buf,
             coasting);
    }
    release(views, 4);
    return (PyObject *)self;
}

static void pieces_dealloc(PyObject *self) {
    PyMem_Free(((Pieces *)self)->memory);
    let_go(self);
}

static int evaluate(const Pieces *self, const double *times, Py_ssize_t count, int first, int last,
                    double *out, size_t stride) {
    jounce_status status;
    if (count * (last - first + 1) >= LONG) {
        Py_BEGIN_ALLOW_THREADS
        status = jounce_evaluate(&self->pieces, times, (size_t)count, first, last, out, stride);
        Py_END_ALLOW_THREADS
    } else {
        status = jounce_evaluate(&self->pieces, times, (size_t)count, first, last, out, stride);
    }
    if (status != JOUNCE_OK) {
        PyErr_SetString(PyExc_ValueError, "times must be finite: got NaN or infinity");
        return 0;
    }
    return 1;
}

/* Times of any kind as an array of doubles: a new reference. */
static PyObject *times_of(State *state, PyObject *given, Py_buffer *view) {
    PyObject *args, *array;
    if (PyObject_CheckBuffer(given) && PyObject_GetBuffer(given, view, READ) == 0) {
        if (of_doubles(view)) {
            Py_INCREF(given);
            return given;
        }
        PyBuffer_Release(view);
    }
    PyErr_Clear();
    args = PyTuple_Pack(2, given, state->number);
    array = args != NULL ? PyObject_Call(state->asarray, args, state->convert) : NULL;
    Py_XDECREF(args);
    if (array != NULL && !look(array, view, READ)) {
        Py_DECREF(array);
        return NULL;
    }
    return array;
}

static int derivative_of(PyObject *object, int *k) {
    long number = PyLong_AsLong(object);
    if (number == -1 && PyErr_Occurred()) {
        return 0;
    }
    *k = number > JOUNCE_MOST_ORDER ? JOUNCE_MOST_ORDER + 1 : (int)number;
    if (number < 0) {
        PyErr_Format(PyExc_ValueError, "derivative %ld: expected 0 or more", number);
    }
    return number >= 0;
}

static PyObject *at_one(const Pieces *self, double time, int k) {
    double value;
    return evaluate(self, &time, 1, k, k, &value, 1) ? PyFloat_FromDouble(value) : NULL;
}

static PyObject *pieces_at(PyObject *self, PyObject *const *args, Py_ssize_t count) {
    State *state = state_of(self);
    PyObject *times, *result = NULL;
    Py_buffer in, out;
    double time;
    int k;
    if (!expect(count, 2, "at(t, derivative)") || !derivative_of(args[1], &k)) {
        return NULL;
    }
    if (plain_number(args[0], &time)) {
        return at_one((Pieces *)self, time, k);
    }
    times = times_of(state, args[0], &in);
    if (times == NULL) {
        return NULL;
    }
    if (in.ndim == 0) {
        result = at_one((Pieces *)self, *(const double *)in.buf, k);
    } else {
        result = new_array(state, -1, &in);
        if (result != NULL && look(result, &out, WRITE)) {
            if (!evaluate((Pieces *)self, in.buf, items(&in), k, k, out.buf, 0)) {
                Py_CLEAR(result);
            }
            PyBuffer_Release(&out);
        } else {
            Py_CLEAR(result);
        }
    }
    PyBuffer_Release(&in);
    Py_DECREF(times);
    return result;
}

/* Whether an array has `rows` rows of the shape of the times, each contiguous. */
static int fits(const Py_buffer *out, Py_ssize_t rows, const Py_buffer *times) {
    Py_ssize_t step = (Py_ssize_t)sizeof(double);
    int i, fit = of_doubles(out) && out->ndim == times->ndim + 1 && out->shape[0] == rows;
    for (i = times->ndim - 1; fit && i >= 0; i--) {
        fit = out->shape[i + 1] == times->shape[i] &&
              (out->strides[i + 1] == step || times->shape[i] < 2);
        step *= times->shape[i];
    }
    return fit && out->strides[0] >= 0 && out->strides[0] % (Py_ssize_t)sizeof(double) == 0;
}

static PyObject *pieces_up_to(PyObject *self, PyObject *const *args, Py_ssize_t count) {
    State *state = state_of(self);
    PyObject *times, *result;
    Py_buffer in, out;
    int k, done = 0;
    if (!expect(count, 3, "up_to(t, highest, out)") || !derivative_of(args[1], &k)) {
        return NULL;
    }
    times = times_of(state, args[0], &in);
    if (times == NULL) {
        return NULL;
    }
    if (args[2] == Py_None) {
        result = new_array(state, k + 1, &in);
    } else {
        result = args[2];
        Py_INCREF(result);
    }
    if (result != NULL &&
        PyObject_GetBuffer(result, &out, PyBUF_STRIDED | PyBUF_FORMAT | PyBUF_WRITABLE) == 0) {
        if (fits(&out, k + 1, &in)) {
            done = evaluate((Pieces *)self, in.buf, items(&in), 0, k, out.buf,
                            (size_t)out.strides[0] / sizeof(double));
        } else {
            PyErr_Format(PyExc_ValueError,
                         "out does not fit: expected an array of float64 with %d rows of the "
                         "shape of the times, contiguous along time", k + 1);
        }
        PyBuffer_Release(&out);
    }
    if (!done) {
        Py_CLEAR(result);
    }
    PyBuffer_Release(&in);
    Py_DECREF(times);
    return result;
}

static PyMethodDef pieces_methods[] = {
    {"at", FAST(pieces_at), METH_FASTCALL,
     "at(t, derivative)\n--\n\nReturn one derivative: a float, or an array of the shape of t."},
    {"up_to", FAST(pieces_up_to), METH_FASTCALL,
     "up_to(t, highest, out)\n--\n\nReturn derivatives 0 to highest, (highest + 1, *t.shape), in "
     "out or, where that is None, a new array."},
    {NULL, NULL, 0, NULL},
};

static PyType_Slot pieces_slots[] = {
    {Py_tp_doc, "Pieces(breaks, states, durations, end_state, coasting)\n--\n\n"
                "A piecewise polynomial of m pieces in Taylor form, copied from arrays of float64 "
                "(m + 1,), (m, n + 1), (m,), (n + 1,).\n\nOutside, derivatives up to `coasting` "
                "go on from the first and the last state, higher ones are zero."},
    {Py_tp_new, (void *)pieces_new},
    {Py_tp_dealloc, (void *)pieces_dealloc},
    {Py_tp_methods, pieces_methods},
    {0, NULL},
};

static PyType_Spec pieces_spec = {
    .name = "jounce.core.binding.Pieces",
    .basicsize = sizeof(Pieces),
    .flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_IMMUTABLETYPE,
    .slots = pieces_slots,
};

/* --- Motion: what the planner returns ----------------------------------------------------------- */

/* Of the pieces there is room for those that it has. */
typedef struct {
    PyObject_VAR_HEAD
    int order;
    jounce_motion motion;
} Motion;

static void row_of(const jounce_piece *piece, int order, double *row) {
    row[0] = piece->x;
    row[1] = piece->v;
    if (order >= 2) {
        row[2] = piece->a;
    }
    if (order == 3) {
        row[3] = piece->j;
    }
}

static void end_row(const jounce_motion *motion, int order, double *row) {
    row[0] = motion->end.x;
    row[1] = motion->end.v;
    if (order >= 2) {
        row[2] = order == 3 ? motion->end.a : 0.0;
    }
    if (order == 3) {
        row[3] = 0.0;
    }
}

static double smaller_of(double a, double b) { return b < a ? b : a; }

enum { MOST_NUMBERS = 2 * JOUNCE_MOST_PIECES + 1 + 4 * (JOUNCE_MOST_PIECES + 1) };

/* Breaks, durations, states and end state of a motion, one after the other. */
static void lay_out(const Motion *self, double *memory) {
    int m = self->motion.count, width = self->order + 1, i;
    double *durations = memory + m + 1, *states = durations + m, time = 0.0;
    memory[0] = 0.0;
    for (i = 0; i < m; i++) {
        const jounce_piece *piece = &self->motion.pieces[i];
        time += piece->duration;
        memory[i + 1] = i + 1 < m ? smaller_of(time, self->motion.duration) : self->motion.duration;
        durations[i] = piece->duration;
        row_of(piece, self->order, states + i * width);
    }
    end_row(&self->motion, self->order, states + m * width);
}

/* A read-only array (rows,) or (rows, width) on some of the bytes. */
static PyObject *array_on(State *state, PyObject *bytes, int at, int rows, int width) {
    PyObject *shape = width > 0 ? Py_BuildValue("(ii)", rows, width) : Py_BuildValue("(i)", rows);
    PyObject *offset = PyLong_FromSize_t((size_t)at * sizeof(double)), *array = NULL;
    if (shape != NULL && offset != NULL) {
        array = PyObject_CallFunctionObjArgs(state->ndarray, shape, state->number, bytes, offset,
                                             NULL);
    }
    Py_XDECREF(shape);
    Py_XDECREF(offset);
    return array;
}

static PyObject *motion_arrays(PyObject *self, PyObject *unused) {
    const Motion *motion = (Motion *)self;
    State *state = state_of(self);
    int m = motion->motion.count, width = motion->order + 1;
    double memory[MOST_NUMBERS];
    PyObject *bytes, *arrays;
    (void)unused;
    lay_out(motion, memory);
    bytes = PyBytes_FromStringAndSize(
        (const char *)memory, (Py_ssize_t)sizeof(double) * (2 * m + 1 + (m + 1) * width));
    if (bytes == NULL) {
        return NULL;
    }
    arrays = Py_BuildValue("(NNNN)", array_on(state, bytes, 0, m + 1, 0),
                           array_on(state, bytes, 2 * m + 1, m, width),
                           array_on(state, bytes, m + 1, m, 0),
                           array_on(state, bytes, 2 * m + 1 + m * width, width, 0));
    Py_DECREF(bytes);
    return arrays;
}

static PyObject *motion_pieces(PyObject *self, PyObject *unused) {
    const Motion *motion = (Motion *)self;
    int m = motion->motion.count, width = motion->order + 1;
    double memory[MOST_NUMBERS];
    Pieces *pieces = new_pieces((PyTypeObject *)state_of(self)->pieces, (size_t)m, motion->order);
    (void)unused;
    if (pieces != NULL) {
        lay_out(motion, memory);
        fill(&pieces->pieces, pieces->memory, memory, memory + 2 * m + 1, memory + m + 1,
             memory + 2 * m + 1 + m * width, motion->order > 1);
    }
    return (PyObject *)pieces;
}

static PyObject *motion_duration(PyObject *self, void *unused) {
    (void)unused;
    return PyFloat_FromDouble(((Motion *)self)->motion.duration);
}

static PyObject *motion_inside_after(PyObject *self, void *unused) {
    (void)unused;
    return PyFloat_FromDouble(((Motion *)self)->motion.inside_after);
}

static PyObject *motion_count(PyObject *self, void *unused) {
    (void)unused;
    return PyLong_FromLong(((Motion *)self)->motion.count);
}

static PyObject *motion_order(PyObject *self, void *unused) {
    (void)unused;
    return PyLong_FromLong(((Motion *)self)->order);
}

static PyObject *motion_end_state(PyObject *self, void *unused) {
    double row[4];
    (void)unused;
    end_row(&((Motion *)self)->motion, ((Motion *)self)->order, row);
    return ((Motion *)self)->order == 3 ? Py_BuildValue("(dddd)", row[0], row[1], row[2], row[3])
                                        : Py_BuildValue("(ddd)", row[0], row[1], row[2]);
}

static PyGetSetDef motion_attributes[] = {
    {"duration", motion_duration, NULL, "The time it takes.", NULL},
    {"inside_after", motion_inside_after, NULL, "When its bounds hold for good.", NULL},
    {"count", motion_count, NULL, "The number m of its pieces.", NULL},
    {"order", motion_order, NULL, "Its highest derivative n, 2 or 3.", NULL},
    {"end_state", motion_end_state, NULL, "Position and derivatives 1 to n at its end.", NULL},
    {NULL, NULL, NULL, NULL, NULL},
};

static PyMethodDef motion_methods[] = {
    {"arrays", motion_arrays, METH_NOARGS,
     "arrays()\n--\n\nReturn breaks (m + 1,), states (m, n + 1), durations (m,) and end state "
     "(n + 1,) as read-only arrays."},
    {"pieces", motion_pieces, METH_NOARGS,
     "pieces()\n--\n\nReturn Pieces that coast on outside at the velocities of start and end."},
    {NULL, NULL, 0, NULL},
};

static PyType_Slot motion_slots[] = {
    {Py_tp_doc, "A motion from time 0 on, as the planner returns it."},
    {Py_tp_dealloc, (void *)let_go},
    {Py_tp_methods, motion_methods},
    {Py_tp_getset, motion_attributes},
    {0, NULL},
};

static PyType_Spec motion_spec = {
    .name = "jounce.core.binding.Motion",
    .basicsize = offsetof(Motion, motion.pieces),
    .itemsize = sizeof(jounce_piece),
    .flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_IMMUTABLETYPE | Py_TPFLAGS_DISALLOW_INSTANTIATION,
    .slots = motion_slots,
};

/* --- transfers -------------------------------------------------------------------------------- */

typedef struct {
    jounce_state start, end;
    jounce_limits limits;
    int order;
} Problem;

/* Read start, end and bounds; 0 with an error set. */
static int problem_of(PyObject *const *args, Problem *p) {
    p->order = plain_limits(args[2], 2, &p->limits);
    if (p->order == 0 || !plain_state(args[0], p->order, &p->start) ||
        !plain_state(args[1], p->order, &p->end)) {
        return 0;
    }
    if (!is_number(p->end.x - p->start.x)) {
        PyErr_SetString(PyExc_ValueError, "the distance between start and end must be finite");
        return 0;
    }
    return 1;
}

static PyObject *new_motion(State *state, int order, const jounce_motion *motion) {
    Motion *self = (Motion *)PyType_GenericAlloc((PyTypeObject *)state->motion, motion->count);
    if (self != NULL) {
        self->order = order;
        memcpy(&self->motion, motion, offsetof(jounce_motion, pieces) +
                                          (size_t)motion->count * sizeof(jounce_piece));
    }
    return (PyObject *)self;
}

/* Put `value`, a new reference, into an object whose class forbids assignment. */
static int put(PyObject *object, PyObject *name, PyObject *value) {
    int done = value != NULL && PyObject_GenericSetAttr(object, name, value) == 0;
    Py_XDECREF(value);
    return done;
}

/* An object of a class that holds a motion, a new reference, and its limits; or without these one
 * of a class of trajectories. It is made here, as its own constructor takes longer than the planner. */
static PyObject *new_trajectory(State *state, PyObject *type, PyObject *motion, PyObject *limits) {
    const Motion *held = (Motion *)motion;
    PyObject *self = NULL;
    if (motion != NULL && PyType_Check(type)) {
        self = PyType_GenericNew((PyTypeObject *)type, NULL, NULL);
    }
    if (self == NULL) {
        Py_XDECREF(motion);
        if (!PyErr_Occurred()) {
            PyErr_SetString(PyExc_TypeError, "expected a class of trajectories");
        }
        return NULL;
    }
    if (!put(self, state->of_motion, motion) ||
        (limits == Py_None ? !put(self, state->of_coasting, PyLong_FromLong(held->order > 1))
                           : !put(self, state->of_limits, Py_NewRef(limits))) ||
        (held->motion.inside_after > 0.0 &&
         !put(self, state->of_inside_after, PyFloat_FromDouble(held->motion.inside_after)))) {
        Py_CLEAR(self);
    }
    return self;
}

/* What came of planning: the status where there is no motion, else a Motion, or a trajectory that
 * holds it where `type` and `limits` follow. */
static PyObject *planned(PyObject *module, int order, const jounce_motion *motion,
                         jounce_status status, PyObject *const *type_and_limits) {
    State *state = PyModule_GetState(module);
    PyObject *found;
    if (status != JOUNCE_OK) {
        return PyLong_FromLong((long)status);
    }
    found = new_motion(state, order, motion);
    return type_and_limits == NULL
               ? found
               : new_trajectory(state, type_and_limits[0], found, type_and_limits[1]);
}

typedef jounce_status (*Planner)(const jounce_state *start, const jounce_state *end,
                                 const jounce_limits *limits, jounce_motion *motion);

static PyObject *plan(PyObject *module, PyObject *const *args, Py_ssize_t count, Planner planner,
                      const char *signature) {
    Problem p;
    jounce_motion motion;
    jounce_status status;
    if (!expect_or(count, 3, 5, signature) || !problem_of(args, &p)) {
        return NULL;
    }
    status = planner(&p.start, &p.end, &p.limits, &motion);
    return planned(module, p.order, &motion, status, count > 3 ? args + 3 : NULL);
}

static PyObject *transfer(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    return plan(module, args, count, jounce_transfer,
                "transfer(start, end, bounds[, type, limits])");
}

static PyObject *velocity_transfer(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    return plan(module, args, count, jounce_velocity_transfer,
                "velocity_transfer(start, end, bounds[, type, limits])");
}

static PyObject *transfer_lasting(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Problem p;
    jounce_motion motion;
    jounce_status status;
    double duration;
    if (!expect_or(count, 4, 6, "transfer_lasting(start, end, bounds, duration[, type, limits])") ||
        !problem_of(args, &p) || !one_number(args[3], &duration)) {
        return NULL;
    }
    if (!is_number(duration)) {
        PyErr_SetString(PyExc_ValueError, "a duration must be finite");
        return NULL;
    }
    status = jounce_transfer_lasting(&p.start, &p.end, &p.limits, duration, &motion);
    return planned(module, p.order, &motion, status, count > 4 ? args + 4 : NULL);
}

static PyObject *possible_durations(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Problem p;
    jounce_durations found;
    PyObject *result;
    int i;
    (void)module;
    if (!expect(count, 3, "possible_durations(start, end, bounds)") || !problem_of(args, &p)) {
        return NULL;
    }
    found.count = 0;
    jounce_possible_durations(&p.start, &p.end, &p.limits, &found);
    result = PyTuple_New(found.count);
    for (i = 0; result != NULL && i < found.count; i++) {
        PyObject *pair = Py_BuildValue("(dd)", found.intervals[i].low, found.intervals[i].high);
        if (pair == NULL) {
            Py_CLEAR(result);
        } else {
            PyTuple_SetItem(result, i, pair);
        }
    }
    return result;
}

/* --- several axes ------------------------------------------------------------------------------- */

enum { MOST_AXES = 64 };

static jounce_state start_of(const jounce_motion *motion) {
    jounce_state start = motion->end;
    if (motion->count > 0) {
        start.x = motion->pieces[0].x;
        start.v = motion->pieces[0].v;
        start.a = motion->pieces[0].a;
    }
    return start;
}

/* Transfers of Python: their motions and limits, in references of their own. */
typedef struct {
    PyObject *given[MOST_AXES], *motions[MOST_AXES], *limits[MOST_AXES];
    jounce_limits bounds[MOST_AXES];
    int count;
} Axes;

static void let_axes_go(Axes *axes) {
    while (axes->count > 0) {
        axes->count--;
        Py_XDECREF(axes->motions[axes->count]);
        Py_XDECREF(axes->limits[axes->count]);
    }
}

static const jounce_motion *motion_of(const Axes *axes, int i) {
    return &((Motion *)axes->motions[i])->motion;
}

/* The attributes of a trajectory that holds a Motion, planned with limits; 0 with an error set. */
static int take_axis(State *state, PyObject *given, PyObject *type, Axes *axes) {
    PyObject *flat = NULL;
    int i, done;
    if ((PyObject *)Py_TYPE(given) != type) {
        PyErr_SetString(PyExc_TypeError, "together: another type");
        return 0;
    }
    i = axes->count++;
    axes->given[i] = given;
    axes->motions[i] = PyObject_GenericGetAttr(given, state->of_motion);
    axes->limits[i] = axes->motions[i] != NULL ? PyObject_GenericGetAttr(given, state->of_limits)
                                               : NULL;
    if (i > 0 && axes->limits[i] == axes->limits[i - 1]) { /* axes often have the same */
        axes->bounds[i] = axes->bounds[i - 1];
        done = 1;
    } else {
        flat = axes->limits[i] != NULL
                   ? PyObject_GenericGetAttr(axes->limits[i], state->of_flat)
                   : NULL;
        done = flat != NULL && plain_limits(flat, 2, &axes->bounds[i]) != 0;
        Py_XDECREF(flat);
    }
    if (done && !PyObject_TypeCheck(axes->motions[i], (PyTypeObject *)state->motion)) {
        PyErr_SetString(PyExc_TypeError, "together: no Motion");
        return 0;
    }
    return done;
}

/* The shortest duration that all axes can take. */
static double common_duration(const Axes *axes) {
    jounce_durations possible[MOST_AXES];
    int i;
    for (i = 0; i < axes->count; i++) {
        const jounce_motion *motion = motion_of(axes, i);
        jounce_state start = start_of(motion);
        jounce_possible_durations(&start, &motion->end, &axes->bounds[i], &possible[i]);
    }
    return jounce_common_duration(possible, axes->count);
}

/* The longest duration of the motions as they are. */
static double longest(const Axes *axes) {
    double duration = 0.0;
    int i;
    for (i = 0; i < axes->count; i++) {
        double own = motion_of(axes, i)->duration;
        duration = own > duration ? own : duration;
    }
    return duration;
}

/* An axis slowed down to a duration: itself where it takes that long, or the status. */
static PyObject *one_lasting(PyObject *module, PyObject *type, const Axes *axes, int i,
                             double duration) {
    const jounce_motion *given = motion_of(axes, i);
    jounce_state start = start_of(given);
    PyObject *type_and_limits[2];
    jounce_motion motion;
    jounce_status status;
    if (given->duration >= duration * (1.0 - 16.0 * 2.220446049250313e-16)) {
        Py_INCREF(axes->given[i]);
        return axes->given[i];
    }
    type_and_limits[0] = type;
    type_and_limits[1] = axes->limits[i];
    status = jounce_transfer_lasting(&start, &given->end, &axes->bounds[i], duration, &motion);
    return planned(module, ((Motion *)axes->motions[i])->order, &motion, status, type_and_limits);
}

/* All axes slowed down to a duration, or the status of one that cannot take it. */
static PyObject *all_lasting(PyObject *module, PyObject *type, const Axes *axes, double duration) {
    PyObject *result = PyTuple_New(axes->count);
    int i;
    for (i = 0; result != NULL && i < axes->count; i++) {
        PyObject *one = one_lasting(module, type, axes, i, duration);
        if (one == NULL || PyLong_Check(one)) {
            Py_DECREF(result);
            return one;
        }
        PyTuple_SetItem(result, i, one);
    }
    return result;
}

/* Whether an axis moves, and is where it is to go: any time but rounding takes it away. */
static int passes_its_end(const Axes *axes) {
    int i;
    for (i = 0; i < axes->count; i++) {
        const jounce_motion *motion = motion_of(axes, i);
        if (motion->count == 0 && (motion->end.v != 0.0 || motion->end.a != 0.0)) {
            return 1;
        }
    }
    return 0;
}

/* Most axes can take the slowest one's time; which durations are possible is asked where not. */
static PyObject *last_together(PyObject *module, PyObject *type, const Axes *axes) {
    double duration;
    if (!passes_its_end(axes)) {
        PyObject *result = all_lasting(module, type, axes, longest(axes));
        if (result == NULL || !PyLong_Check(result)) {
            return result;
        }
        Py_DECREF(result);
    }
    duration = common_duration(axes);
    return is_number(duration) ? all_lasting(module, type, axes, duration)
                               : PyLong_FromLong((long)JOUNCE_NO_DURATION);
}

/* What was made of the axes, a new reference, and the limits of these; a status as it is. */
static PyObject *with_limits(PyObject *made, const Axes *axes) {
    PyObject *limits;
    int i;
    if (made == NULL || PyLong_Check(made)) {
        return made;
    }
    limits = PyTuple_New(axes->count);
    for (i = 0; limits != NULL && i < axes->count; i++) {
        PyTuple_SetItem(limits, i, Py_NewRef(axes->limits[i]));
    }
    return Py_BuildValue("(NN)", made, limits);
}

static PyObject *together(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    State *state = PyModule_GetState(module);
    PyObject *result = NULL;
    Axes axes;
    Py_ssize_t given, i;
    if (!expect(count, 2, "together(transfers, type)")) {
        return NULL;
    }
    given = PyTuple_Check(args[0]) ? PyTuple_Size(args[0]) : -1;
    if (given < 0 || given > MOST_AXES) {
        PyErr_Format(PyExc_ValueError, "together: expected a tuple of at most %d", MOST_AXES);
        return NULL;
    }
    axes.count = 0;
    for (i = 0; i < given && take_axis(state, PyTuple_GetItem(args[0], i), args[1], &axes); i++) {
    }
    if (i == given) {
        result = with_limits(last_together(module, args[1], &axes), &axes);
    }
    let_axes_go(&axes);
    return result;
}

/* --- many transfers ----------------------------------------------------------------------------- */

/* Numbers of many problems; those of all where a step is zero. Of moves the starts are distances,
 * and the ends positions to start from. */
typedef struct {
    int order;
    Py_ssize_t count;
    const double *starts, *ends, *bounds;
    Py_ssize_t start_step, end_step, bounds_step;
} Problems;

static Py_ssize_t step_of(const Py_buffer *view, Py_ssize_t each, Py_ssize_t count) {
    return count > 1 && items(view) == each ? 0 : each;
}

static Problems problems_of(const Py_buffer *views, int order, Py_ssize_t each,
                            Py_ssize_t count) {
    Problems p;
    p.order = order;
    p.count = count;
    p.starts = views[0].buf;
    p.ends = views[1].buf;
    p.bounds = views[2].buf;
    p.start_step = step_of(&views[0], each, count);
    p.end_step = step_of(&views[1], each, count);
    p.bounds_step = step_of(&views[2], (Py_ssize_t)order * 2, count);
    return p;
}

static jounce_state state_at(const double *row, int order) {
    jounce_state state;
    state.x = row[0];
    state.v = row[1];
    state.a = order == 3 ? row[2] : 0.0;
    return state;
}

/* Plan problem i. */
typedef jounce_status (*Solver)(const Problems *p, Py_ssize_t i, jounce_motion *motion);

static jounce_status solve(const Problems *p, Py_ssize_t i, jounce_motion *motion,
                           int times_alone) {
    jounce_state start = state_at(p->starts + i * p->start_step, p->order);
    jounce_state end = state_at(p->ends + i * p->end_step, p->order);
    jounce_limits limits = limits_of(p->bounds + i * p->bounds_step, p->order);
    return times_alone ? jounce_transfer_times(&start, &end, &limits, motion)
                       : jounce_transfer(&start, &end, &limits, motion);
}

static jounce_status solve_transfer(const Problems *p, Py_ssize_t i, jounce_motion *motion) {
    return solve(p, i, motion, 0);
}

/* The order of problems, `least` to 3; 0 with an error set. */
static int order_of(PyObject *object, int least) {
    long order = PyLong_AsLong(object);
    if ((order < least || order > 3) && !PyErr_Occurred()) {
        PyErr_Format(PyExc_ValueError, "order = %ld: expected %d to 3", order, least);
    }
    return order >= least && order <= 3 ? (int)order : 0;
}

static void solve_all(const Problems *p, double *durations, double *inside, signed char *statuses,
                      signed char *counts) {
    jounce_motion motion;
    Py_ssize_t i;
    for (i = 0; i < p->count; i++) {
        jounce_status status = solve(p, i, &motion, 1);
        int ok = status == JOUNCE_OK;
        statuses[i] = (signed char)status;
        counts[i] = (signed char)(ok ? motion.count : 0);
        durations[i] = ok ? motion.duration : (double)NAN;
        inside[i] = ok ? motion.inside_after : (double)NAN;
    }
}

static PyObject *transfers(PyObject *module, PyObject *const *args, Py_ssize_t given) {
    Py_buffer views[7];
    Wanted wanted[7];
    Problems p;
    Py_ssize_t count;
    int order;
    (void)module;
    if (!expect(given, 8, "transfers(order, starts, ends, bounds, durations, inside_after, "
                          "statuses, counts)")) {
        return NULL;
    }
    order = order_of(args[0], 2);
    count = order != 0 ? PyObject_Size(args[4]) : -1;
    if (count < 0) {
        return NULL;
    }
    wanted[0] = doubles_for_all(args[1], order, count);
    wanted[1] = doubles_for_all(args[2], order, count);
    wanted[2] = doubles_for_all(args[3], (Py_ssize_t)order * 2, count);
    wanted[3] = room(args[4], count);
    wanted[4] = room(args[5], count);
    wanted[5] = room_for_bytes(args[6], count);
    wanted[6] = room_for_bytes(args[7], count);
    if (!look_into(wanted, 7, views)) {
        return NULL;
    }
    p = problems_of(views, order, order, count);
    Py_BEGIN_ALLOW_THREADS
    solve_all(&p, views[3].buf, views[4].buf, views[5].buf, views[6].buf);
    Py_END_ALLOW_THREADS
    release(views, 7);
    Py_RETURN_NONE;
}

/* Pieces of all motions, `most` of each: those that a motion lacks take no time, at its end. */
static void lay_out_one(const jounce_motion *motion, int order, int most, double *lengths,
                        double *states, double *end) {
    int width = order + 1, k;
    end_row(motion, order, end);
    for (k = 0; k < most; k++) {
        double *row = states + k * width;
        lengths[k] = k < motion->count ? motion->pieces[k].duration : 0.0;
        if (k < motion->count) {
            row_of(&motion->pieces[k], order, row);
        } else {
            memcpy(row, end, (size_t)width * sizeof(double));
        }
    }
}

/* What no motion is: no time at no place. */
static void lay_out_none(int order, int most, double *lengths, double *states, double *end) {
    int width = order + 1, k;
    for (k = 0; k < most; k++) {
        lengths[k] = 0.0;
    }
    for (k = 0; k < most * width; k++) {
        states[k] = (double)NAN;
    }
    for (k = 0; k < width; k++) {
        end[k] = (double)NAN;
    }
}

static void lay_out_all(const Problems *p, Solver solver, int most, double *lengths,
                        double *states, double *ends) {
    int width = p->order + 1;
    jounce_motion motion;
    Py_ssize_t i;
    for (i = 0; i < p->count; i++) {
        double *own = states + i * most * width;
        if (solver(p, i, &motion) == JOUNCE_OK) {
            lay_out_one(&motion, p->order, most, lengths + i * most, own, ends + i * width);
        } else {
            lay_out_none(p->order, most, lengths + i * most, own, ends + i * width);
        }
    }
}

/* The number of pieces to lay out of each motion; -1 with an error set. */
static int most_of(PyObject *object) {
    long most = PyLong_AsLong(object);
    if ((most < 0 || most > JOUNCE_MOST_PIECES) && !PyErr_Occurred()) {
        PyErr_Format(PyExc_ValueError, "most = %ld: expected 0 to %d", most, JOUNCE_MOST_PIECES);
    }
    return most >= 0 && most <= JOUNCE_MOST_PIECES ? (int)most : -1;
}

/* Put pieces in place; a problem has `each` numbers in the first array, and in the second. */
static PyObject *pieces_of_all(PyObject *const *args, int order, int each, Solver solver) {
    Py_ssize_t count = order != 0 ? PyObject_Size(args[5]) : -1;
    int most = count < 0 ? -1 : most_of(args[4]);
    Py_buffer views[6];
    Wanted wanted[6];
    Problems p;
    if (most < 0) {
        return NULL;
    }
    wanted[0] = doubles_for_all(args[1], each, count);
    wanted[1] = doubles_for_all(args[2], each, count);
    wanted[2] = doubles_for_all(args[3], (Py_ssize_t)order * 2, count);
    wanted[3] = room(args[5], count * most);
    wanted[4] = room(args[6], count * most * (order + 1));
    wanted[5] = room(args[7], count * (order + 1));
    if (!look_into(wanted, 6, views)) {
        return NULL;
    }
    p = problems_of(views, order, each, count);
    Py_BEGIN_ALLOW_THREADS
    lay_out_all(&p, solver, most, views[3].buf, views[4].buf, views[5].buf);
    Py_END_ALLOW_THREADS
    release(views, 6);
    Py_RETURN_NONE;
}

static PyObject *transfer_pieces(PyObject *module, PyObject *const *args, Py_ssize_t given) {
    int order;
    (void)module;
    if (!expect(given, 8, "transfer_pieces(order, starts, ends, bounds, most, lengths, states, "
                          "end_states)")) {
        return NULL;
    }
    order = order_of(args[0], 2);
    return pieces_of_all(args, order, order, solve_transfer);
}

/* --- many moves --------------------------------------------------------------------------------- */

static jounce_column column_of(const Py_buffer *view, Py_ssize_t count) {
    jounce_column column;
    column.values = view->buf;
    column.step = (size_t)step_of(view, 1, count);
    return column;
}

/* Look into distances, durations, upper and lower bounds; how many views were taken, or 0. */
static int look_into_moves(PyObject *const *args, Py_ssize_t count, jounce_columns *bounds,
                           Py_buffer *views) {
    Wanted wanted[8];
    int k, n = bounds->order, sides = 2 + (bounds->even ? n : 2 * n);
    wanted[0] = doubles_for_all(args[1], 1, count);
    wanted[1] = room(args[4], count);
    for (k = 0; k < n; k++) {
        wanted[2 + k] = doubles_for_all(PyTuple_GetItem(args[3], k), 1, count);
        if (!bounds->even) {
            wanted[2 + n + k] = doubles_for_all(PyTuple_GetItem(args[2], k), 1, count);
        }
    }
    if (!look_into(wanted, sides, views)) {
        return 0;
    }
    for (k = 0; k < n; k++) {
        bounds->upper[k] = column_of(&views[2 + k], count);
        if (!bounds->even) {
            bounds->lower[k] = column_of(&views[2 + n + k], count);
        }
    }
    return sides;
}

static int is_tuple_of(PyObject *object, Py_ssize_t count) {
    return PyTuple_Check(object) && PyTuple_Size(object) == count;
}

static PyObject *move_durations(PyObject *module, PyObject *const *args, Py_ssize_t given) {
    Py_buffer views[8];
    Py_ssize_t count;
    jounce_column distances;
    jounce_columns bounds;
    int taken;
    (void)module;
    if (!expect(given, 5, "move_durations(order, distances, lower, upper, durations)")) {
        return NULL;
    }
    bounds.order = order_of(args[0], 1);
    bounds.even = args[2] == Py_None;
    count = bounds.order != 0 ? PyObject_Size(args[4]) : -1;
    if (count < 0) {
        return NULL;
    }
    if (!is_tuple_of(args[3], bounds.order) ||
        !(bounds.even || is_tuple_of(args[2], bounds.order))) {
        PyErr_SetString(PyExc_TypeError, "move_durations: expected tuples of as many bounds as the "
                                         "order says");
        return NULL;
    }
    taken = look_into_moves(args, count, &bounds, views);
    if (taken == 0) {
        return NULL;
    }
    distances = column_of(&views[0], count);
    Py_BEGIN_ALLOW_THREADS
    jounce_move_durations(&distances, &bounds, (size_t)count, views[1].buf);
    Py_END_ALLOW_THREADS
    release(views, taken);
    Py_RETURN_NONE;
}

/* A move from a position on. */
static jounce_status move_from(double start, double distance, const jounce_limits *limits,
                               jounce_motion *motion) {
    jounce_status status = jounce_move(distance, limits, motion);
    int i;
    for (i = 0; i < motion->count; i++) {
        motion->pieces[i].x += start;
    }
    motion->end.x = start + distance;
    return status;
}

static jounce_status solve_move(const Problems *p, Py_ssize_t i, jounce_motion *motion) {
    jounce_limits limits = limits_of(p->bounds + i * p->bounds_step, p->order);
    return move_from(p->ends[i * p->end_step], p->starts[i * p->start_step], &limits, motion);
}

static PyObject *move_pieces(PyObject *module, PyObject *const *args, Py_ssize_t given) {
    (void)module;
    if (!expect(given, 8, "move_pieces(order, distances, starts, bounds, most, lengths, states, "
                          "end_states)")) {
        return NULL;
    }
    return pieces_of_all(args, order_of(args[0], 1), 1, solve_move);
}

/* --- values of many motions --------------------------------------------------------------------- */

/* Motions of up to `most` pieces; those that take no time are passed over. */
typedef struct {
    int order, first, last;
    Py_ssize_t count, most, points, times_step; /* the times of all where the step is zero */
    const double *durations, *lengths, *states, *ends, *times;
    double *out;
} Lanes;

/* What is no motion, its duration NaN, has no values. */
static void put_nothing(const Lanes *l, Py_ssize_t i) {
    Py_ssize_t k, j;
    for (k = 0; k <= l->last - l->first; k++) {
        for (j = 0; j < l->points; j++) {
            l->out[(k * l->count + i) * l->points + j] = (double)NAN;
        }
    }
}

/* One after the other, in memory for the breaks and the states of one, zero before. */
static jounce_status evaluate_all(const Lanes *l, double *memory) {
    Py_ssize_t width = l->order + 1, i, k;
    size_t row = (size_t)width * sizeof(double);
    double *breaks = memory, *states = memory + l->most + 1;
    size_t known = (size_t)(l->order < 2 ? 1 : 2) * sizeof(double);
    jounce_status status = JOUNCE_OK;
    jounce_pieces pieces;
    pieces.order = l->order;
    pieces.count = (size_t)l->most;
    pieces.breaks = breaks;
    pieces.states = states;
    for (i = 0; i < l->count && status == JOUNCE_OK; i++) {
        const double *own = l->states + i * l->most * width, *end = l->ends + i * width;
        if (l->durations[i] != l->durations[i]) {
            put_nothing(l, i);
            continue;
        }
        pieces.durations = l->lengths + i * l->most;
        for (k = 0; k < l->most; k++) {
            breaks[k + 1] = smaller_of(breaks[k] + pieces.durations[k], l->durations[i]);
        }
        breaks[l->most] = l->durations[i];
        memcpy(states, l->most > 0 ? own : end, known);
        memcpy(states + width, own, (size_t)l->most * row);
        memcpy(states + (l->most + 1) * width, end, known);
        status = jounce_evaluate(&pieces, l->times + i * l->times_step, (size_t)l->points, l->first,
                                 l->last, l->out + i * l->points, (size_t)(l->count * l->points));
    }
    return status;
}

/* How many numbers an array has for each of `count` problems; -1 with TypeError. */
static Py_ssize_t items_each(PyObject *object, Py_ssize_t count) {
    Py_buffer view;
    Py_ssize_t size;
    if (!look(object, &view, READ)) {
        return -1;
    }
    size = items(&view);
    PyBuffer_Release(&view);
    return count > 0 ? size / count : 0;
}

/* Read the sizes of everything; 0 with an error set. */
static int sizes_of(PyObject *const *args, Lanes *l) {
    Py_ssize_t width;
    if (!derivative_of(args[6], &l->first) || !derivative_of(args[7], &l->last)) {
        return 0;
    }
    l->count = PyObject_Size(args[3]);
    l->points = PyLong_AsSsize_t(args[5]);
    if (l->count < 0 || (l->points < 0 && PyErr_Occurred())) {
        return 0;
    }
    width = items_each(args[3], l->count);
    l->most = width < 0 ? -1 : items_each(args[1], l->count);
    if (l->most < 0) {
        return 0;
    }
    l->order = l->count > 0 ? (int)width - 1 : 1;
    if (l->order < 1 || l->order > JOUNCE_MOST_ORDER || l->last < l->first || l->points < 0) {
        PyErr_SetString(PyExc_ValueError, "evaluate_lanes: expected states (N, m, n + 1) of order "
                                          "n = 1 to 40, and first <= last");
        return 0;
    }
    return 1;
}

static int look_into_lanes(PyObject *const *args, Lanes *l, Py_buffer *views) {
    Wanted wanted[6];
    wanted[0] = doubles(args[1], l->count * l->most);
    wanted[1] = doubles(args[2], l->count * l->most * (l->order + 1));
    wanted[2] = doubles(args[3], l->count * (l->order + 1));
    wanted[3] = doubles_for_all(args[4], l->points, l->count);
    wanted[4] = room(args[8], (l->last - l->first + 1) * l->count * l->points);
    wanted[5] = doubles(args[0], l->count);
    if (!look_into(wanted, 6, views)) {
        return 0;
    }
    l->lengths = views[0].buf;
    l->states = views[1].buf;
    l->ends = views[2].buf;
    l->times = views[3].buf;
    l->times_step = step_of(&views[3], l->points, l->count);
    l->out = views[4].buf;
    l->durations = views[5].buf;
    return 1;
}

static PyObject *evaluate_lanes(PyObject *module, PyObject *const *args, Py_ssize_t given) {
    Py_buffer views[6];
    Lanes l;
    double *memory;
    jounce_status status = JOUNCE_OK;
    (void)module;
    if (!expect(given, 9, "evaluate_lanes(durations, lengths, states, end_states, times, points, "
                          "first, last, out)") ||
        !sizes_of(args, &l) || !look_into_lanes(args, &l, views)) {
        return NULL;
    }
    memory = PyMem_Calloc((size_t)(l.most + 1 + (l.most + 2) * (l.order + 1)), sizeof(double));
    if (memory != NULL) {
        Py_BEGIN_ALLOW_THREADS
        status = evaluate_all(&l, memory);
        Py_END_ALLOW_THREADS
    }
    PyMem_Free(memory);
    release(views, 6);
    if (memory == NULL) {
        return PyErr_NoMemory();
    }
    if (status != JOUNCE_OK) {
        PyErr_SetString(PyExc_ValueError, "times must be finite: got NaN or infinity");
        return NULL;
    }
    Py_RETURN_NONE;
}

static PyObject *tuple_of(const double *values, int count) {
    PyObject *tuple = PyTuple_New(count);
    int i;
    for (i = 0; tuple != NULL && i < count; i++) {
        PyObject *number = PyFloat_FromDouble(values[i]);
        if (number == NULL) {
            Py_CLEAR(tuple);
        } else {
            PyTuple_SetItem(tuple, i, number);
        }
    }
    return tuple;
}

/* --- bounds -------------------------------------------------------------------------------------- */

/* A positive number, a pair of numbers around zero, or None; 0 for anything else. */
static int plain_bound(PyObject *object, double *low, double *high) {
    double pair[2];
    if (object == Py_None) {
        *low = -Py_HUGE_VAL;
        *high = Py_HUGE_VAL;
        return 1;
    }
    if (plain_number(object, high)) {
        *low = -*high;
    } else if (plain_numbers(object, pair, 2) == 2) {
        *low = pair[0];
        *high = pair[1];
    } else {
        PyErr_Clear();
        return 0;
    }
    return *low < 0.0 && *high > 0.0;
}

/* A number as an object: the one given where it is that. */
static PyObject *object_of(double number, PyObject *given) {
    return PyFloat_CheckExact(given) && PyFloat_AsDouble(given) == number
               ? Py_NewRef(given)
               : PyFloat_FromDouble(number);
}

/* Lower bounds, upper bounds, and both in turn, which are the same objects. */
static PyObject *lower_upper_flat(const double *flat, PyObject *const *given, int count) {
    PyObject *sides[] = {PyTuple_New(count), PyTuple_New(count)}, *both = PyTuple_New(2 * count);
    int k, good = sides[0] != NULL && sides[1] != NULL && both != NULL;
    for (k = 0; good && k < 2 * count; k++) {
        PyObject *number = object_of(flat[k], given[k / 2]);
        good = number != NULL;
        if (good) {
            PyTuple_SetItem(sides[k % 2], k / 2, Py_NewRef(number));
            PyTuple_SetItem(both, k, number);
        }
    }
    if (!good) {
        Py_XDECREF(sides[0]);
        Py_XDECREF(sides[1]);
        Py_XDECREF(both);
        return NULL;
    }
    return Py_BuildValue("(NNN)", sides[0], sides[1], both);
}

static PyObject *bounds_of(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    double flat[2 * JOUNCE_MOST_ORDER];
    Py_ssize_t i;
    int known = count > 0 && count <= JOUNCE_MOST_ORDER, order = 0;
    (void)module;
    for (i = 0; known && i < count; i++) {
        known = plain_bound(args[i], &flat[2 * i], &flat[2 * i + 1]);
        if (known && (is_number(flat[2 * i]) || is_number(flat[2 * i + 1]))) {
            order = (int)i + 1;
        }
    }
    if (!known || order == 0) {
        Py_RETURN_NONE;
    }
    return lower_upper_flat(flat, args, order);
}

/* --- moves ------------------------------------------------------------------------------------- */

static PyObject *move(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    jounce_limits limits;
    jounce_status status;
    double distance, start;
    jounce_motion motion;
    int order;
    if (!expect_or(count, 3, 5, "move(distance, bounds, start[, type, limits])") ||
        !one_number(args[0], &distance) || !one_number(args[2], &start)) {
        return NULL;
    }
    if (!is_number(distance) || !is_number(start) || !is_number(start + distance)) {
        PyErr_SetString(PyExc_ValueError, "distance and start must be finite");
        return NULL;
    }
    order = plain_limits(args[1], 1, &limits);
    if (order == 0) {
        return NULL;
    }
    status = move_from(start, distance, &limits, &motion);
    return planned(module, order, &motion, status, count > 3 ? args + 3 : NULL);
}

/* --- followers ---------------------------------------------------------------------------------- */

/* A state is position, velocity, acceleration[, jerk], then the lags of a jerk filter. */
typedef struct {
    PyObject_HEAD
    jounce_follower follower;
    double omega;
    int order, lags;
} Follower;

enum { MOST_STATES = 4 + JOUNCE_MOST_LAGS };

static PyObject *follower_new(PyTypeObject *type, PyObject *args, PyObject *names) {
    PyObject *bounds;
    jounce_limits limits;
    double dt, period, omega;
    Follower *self;
    int lags, order;
    if (names != NULL && PyDict_Size(names) > 0) {
        PyErr_SetString(PyExc_TypeError, "Follower takes no keyword arguments");
        return NULL;
    }
    if (!PyArg_ParseTuple(args, "Odddi:Follower", &bounds, &dt, &period, &omega, &lags)) {
        return NULL;
    }
    order = plain_limits(bounds, 2, &limits);
    if (order == 0) {
        return NULL;
    }
    if (!(dt > 0.0 && is_number(dt)) || !(period > 0.0) || lags < 0 || lags > JOUNCE_MOST_LAGS ||
        (lags > 0 && !(omega > 0.0 && is_number(omega)))) {
        PyErr_SetString(PyExc_ValueError, "Follower: dt, period or filter out of range");
        return NULL;
    }
    self = (Follower *)PyType_GenericNew(type, NULL, NULL);
    if (self != NULL) {
        self->follower.limits = limits;
        self->follower.dt = dt;
        self->follower.period = period;
        self->omega = omega;
        self->order = order;
        self->lags = lags;
    }
    return (PyObject *)self;
}

/* Go on by one sample, in place. */
static jounce_status follow_on(const Follower *self, double command, double velocity,
                               double *states) {
    jounce_state state;
    jounce_motion motion;
    jounce_status status;
    state.x = states[0];
    state.v = states[1];
    state.a = self->order == 3 ? states[2] : 0.0;
    status = jounce_follow(&self->follower, &state, command, velocity, &motion);
    if (status == JOUNCE_OK) {
        states[0] = motion.end.x;
        states[1] = motion.end.v;
        states[2] = motion.end.a;
        if (self->order == 3) {
            states[3] = motion.count > 0 ? motion.pieces[motion.count - 1].j : 0.0;
        }
        jounce_lags_behind(states + self->order + 1, self->lags, &motion, self->follower.dt,
                           self->omega);
    }
    return status;
}

static void put_out(const Follower *self, const double *states, double *out) {
    jounce_lags_output(states + self->order + 1, self->lags, states, self->order, self->omega, out);
}

/* The full state, lags left out at rest at the position; 0 with an error set. */
static int follower_state(const Follower *self, PyObject *given, double *states) {
    int own = self->order + 1, i;
    Py_ssize_t count = plain_numbers(given, states, MOST_STATES);
    if (count < 0) {
        return 0;
    }
    if (count < 1 || (count > own && count != own + self->lags)) {
        PyErr_SetString(PyExc_ValueError, "a state of another length");
        return 0;
    }
    for (i = (int)count; i < own; i++) {
        states[i] = 0.0;
    }
    for (i = own; count <= own && i < own + self->lags; i++) {
        states[i] = states[0];
    }
    for (i = 0; i < own + self->lags; i++) {
        if (!is_number(states[i])) {
            PyErr_SetString(PyExc_ValueError, "a state must be finite");
            return 0;
        }
    }
    return 1;
}

static PyObject *follower_step(PyObject *object, PyObject *const *args, Py_ssize_t count) {
    const Follower *self = (Follower *)object;
    double states[MOST_STATES], command, velocity;
    jounce_status status;
    if (!expect(count, 3, "step(state, command, command_velocity)") ||
        !follower_state(self, args[0], states) || !one_number(args[1], &command) ||
        !one_number(args[2], &velocity)) {
        return NULL;
    }
    if (!is_number(command) || !is_number(velocity)) {
        PyErr_SetString(PyExc_ValueError, "a command must be finite");
        return NULL;
    }
    status = follow_on(self, command, velocity, states);
    return status == JOUNCE_OK ? tuple_of(states, self->order + 1 + self->lags)
                               : PyLong_FromLong((long)status);
}

static PyObject *follower_output(PyObject *object, PyObject *const *args, Py_ssize_t count) {
    const Follower *self = (Follower *)object;
    double states[MOST_STATES], out[4];
    if (!expect(count, 1, "output(state)") || !follower_state(self, args[0], states)) {
        return NULL;
    }
    put_out(self, states, out);
    return tuple_of(out, self->order + 1);
}

/* Rows of the output, one column a sample; the status of the first sample that failed. */
static jounce_status run_all(const Follower *self, const double *commands,
                             const double *velocities, Py_ssize_t velocity_step, Py_ssize_t count,
                             double *states, double *rows) {
    double out[4];
    Py_ssize_t k;
    int i;
    for (k = 0; k < count; k++) {
        jounce_status status =
            follow_on(self, commands[k], velocities[k * velocity_step], states);
        if (status != JOUNCE_OK) {
            return status;
        }
        put_out(self, states, out);
        for (i = 0; i <= self->order; i++) {
            rows[i * count + k] = out[i];
        }
    }
    return JOUNCE_OK;
}

static PyObject *follower_run(PyObject *object, PyObject *const *args, Py_ssize_t given) {
    const Follower *self = (Follower *)object;
    double states[MOST_STATES];
    jounce_status status;
    Py_buffer views[3];
    Wanted wanted[3];
    Py_ssize_t count;
    if (!expect(given, 4, "run(state, commands, command_velocities, rows)") ||
        !follower_state(self, args[0], states)) {
        return NULL;
    }
    count = PyObject_Size(args[1]);
    if (count < 0) {
        return NULL;
    }
    wanted[0] = doubles(args[1], count);
    wanted[1] = doubles_for_all(args[2], 1, count);
    wanted[2] = room(args[3], count * (self->order + 1));
    if (!look_into(wanted, 3, views)) {
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    status = run_all(self, views[0].buf, views[1].buf, items(&views[1]) == 1 ? 0 : 1, count,
                     states, views[2].buf);
    Py_END_ALLOW_THREADS
    release(views, 3);
    return PyLong_FromLong((long)status);
}

/* The pieces of a sample: durations, then positions and derivatives when each begins. */
static PyObject *follower_pieces(PyObject *object, PyObject *const *args, Py_ssize_t count) {
    const Follower *self = (Follower *)object;
    double states[MOST_STATES], command, velocity;
    jounce_state state;
    jounce_motion motion;
    PyObject *list;
    int i;
    if (!expect(count, 3, "pieces(state, command, command_velocity)") ||
        !follower_state(self, args[0], states) || !one_number(args[1], &command) ||
        !one_number(args[2], &velocity)) {
        return NULL;
    }
    state.x = states[0];
    state.v = states[1];
    state.a = self->order == 3 ? states[2] : 0.0;
    if (jounce_follow(&self->follower, &state, command, velocity, &motion) != JOUNCE_OK) {
        return PyLong_FromLong((long)JOUNCE_RANGE);
    }
    list = PyList_New(0);
    for (i = 0; list != NULL && i < motion.count; i++) {
        double row[4];
        PyObject *piece;
        row_of(&motion.pieces[i], self->order, row);
        piece = Py_BuildValue("(dN)", motion.pieces[i].duration, tuple_of(row, self->order + 1));
        if (piece == NULL || PyList_Append(list, piece) < 0) {
            Py_CLEAR(list);
        }
        Py_XDECREF(piece);
    }
    return list;
}

static PyObject *advance_lags(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    double lags[JOUNCE_MOST_LAGS], motion[4], tau, omega;
    Py_ssize_t m, width;
    (void)module;
    if (!expect(count, 4, "advance_lags(lags, motion, tau, omega)")) {
        return NULL;
    }
    m = plain_numbers(args[0], lags, JOUNCE_MOST_LAGS);
    width = m < 0 ? -1 : plain_numbers(args[1], motion, 4);
    if (width < 0 || !one_number(args[2], &tau) || !one_number(args[3], &omega)) {
        return NULL;
    }
    if (m == 0 || width == 0) {
        PyErr_SetString(PyExc_ValueError, "no lags, or no motion");
        return NULL;
    }
    jounce_advance_lags(lags, (int)m, motion, (int)width - 1, tau, omega);
    return tuple_of(lags, (int)m);
}

static PyMethodDef follower_methods[] = {
    {"step", FAST(follower_step), METH_FASTCALL,
     "step(state, command, command_velocity)\n--\n\nReturn the state one sample later, or the "
     "status."},
    {"output", FAST(follower_output), METH_FASTCALL,
     "output(state)\n--\n\nReturn position and derivatives that come out in a state."},
    {"run", FAST(follower_run), METH_FASTCALL,
     "run(state, commands, command_velocities, rows)\n--\n\nPut what comes out after each sample "
     "in place, (order + 1, N); return the status."},
    {"pieces", FAST(follower_pieces), METH_FASTCALL,
     "pieces(state, command, command_velocity)\n--\n\nReturn the pieces of a sample, (duration, "
     "row) each."},
    {NULL, NULL, 0, NULL},
};

static PyType_Slot follower_slots[] = {
    {Py_tp_doc, "Follower(bounds, dt, period, omega, lags)\n--\n\nFollows commands one sample at "
                "a time; an infinite period is none, no lags no filter."},
    {Py_tp_new, (void *)follower_new},
    {Py_tp_dealloc, (void *)let_go},
    {Py_tp_methods, follower_methods},
    {0, NULL},
};

static PyType_Spec follower_spec = {
    .name = "jounce.core.binding.Follower",
    .basicsize = sizeof(Follower),
    .flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_IMMUTABLETYPE,
    .slots = follower_slots,
};

/* --- servo loops (loop.c) ------------------------------------------------------------------------ */

enum { LOOP_NUMBERS = 14, CONTROLLER_NUMBERS = 16, LOOP_ARRAYS = 18, MOST_SEGMENTS = 2000000 };

/* What a loop is given, as the core takes it. */
typedef struct {
    jounce_automaton automaton;
    jounce_controller controller;
    jounce_loop loop;
    double steps[2];
    int mode;
} Loop;

static void read_numbers(Loop *l, const double *x) {
    jounce_automaton *a = &l->automaton;
    a->states = (int)x[0];
    a->moving = (int)x[1];
    a->modes = (int)x[2];
    a->guards = (int)x[3];
    l->steps[0] = x[4];
    l->steps[1] = x[5];
    l->mode = (int)x[6];
    l->loop.duration = x[7];
    l->loop.delay = x[8];
    l->loop.samples = (int)x[9];
    l->loop.held = (int)x[10];
    l->loop.settings = (int)x[11];
    l->loop.place = (int)x[12];
    l->loop.width = (int)x[13];
}

static void read_controller(jounce_controller *c, const double *x) {
    c->law = (int)x[0];
    c->anti_windup = (int)x[1];
    c->sections = (int)x[2];
    c->order = (int)x[3];
    c->dt = x[4];
    c->kp = x[5];
    c->ki = x[6];
    c->kr = x[7];
    c->rate_filter = x[8];
    c->position_gain = x[9];
    c->velocity_feedforward = x[10];
    c->friction = x[11];
    c->limit = x[12];
    c->tracking_time = x[13];
    c->integral_limit = x[14];
    c->encoder_step = x[15];
}

/* Sizes that the arrays are measured by; 0 with ValueError for others. */
static int loop_makes_sense(const Loop *l) {
    const jounce_automaton *a = &l->automaton;
    const jounce_loop *o = &l->loop;
    int good = a->moving > 0 && a->moving <= a->states && a->modes > 0 && a->guards >= 0 &&
               a->states < 1000 && a->modes < 1000 && a->guards < 100 && l->steps[1] > 0.0 &&
               l->steps[0] >= l->steps[1] && l->mode >= 0 && l->mode < a->modes &&
               o->samples >= 0 && o->settings >= 0 && o->width >= 0 && o->place >= 0 &&
               o->place + o->width <= a->states && o->held >= 0 && o->held < a->states &&
               l->controller.sections >= 0 && l->controller.order >= 1 && l->controller.dt > 0.0;
    if (!good) {
        PyErr_SetString(PyExc_ValueError, "numbers of a loop that fit no arrays");
    }
    return good;
}

/* Look into the arrays: rates, rows, next, onto, along, z, position, motor, section, gains of
 * position and torque, commands, ahead, noise, times, values, state and out. */
static int look_into_loop(PyObject *const *args, const Loop *l, Py_buffer *views) {
    const jounce_automaton *a = &l->automaton;
    Py_ssize_t n = a->states, modes = a->modes, samples = l->loop.samples;
    Py_ssize_t width = l->controller.order + 1, sections = l->controller.sections;
    const Wanted wanted[LOOP_ARRAYS] = {
        doubles(args[0], modes * a->moving * n),
        doubles(args[1], modes * a->guards * n),
        doubles(args[2], modes * a->guards),
        doubles(args[3], modes * a->guards * n),
        doubles(args[4], modes * a->guards * n),
        room(args[5], n),
        doubles(args[6], n),
        doubles(args[7], n),
        doubles(args[8], 5 * sections),
        doubles(args[9], width),
        doubles(args[10], width),
        doubles(args[11], samples * width),
        doubles(args[12], samples * width),
        doubles_for_all(args[13], 0, samples),
        doubles(args[14], l->loop.settings),
        doubles(args[15], l->loop.settings * (Py_ssize_t)l->loop.width),
        room(args[16], JOUNCE_CONTROLLER_STATE(sections)),
        room(args[17], 3 * samples),
    };
    Wanted all[LOOP_ARRAYS];
    memcpy(all, wanted, sizeof wanted);
    all[13].or_count = samples;
    return look_into(all, LOOP_ARRAYS, views);
}

static void point_into(Loop *l, const Py_buffer *views) {
    l->automaton.rates = views[0].buf;
    l->automaton.rows = views[1].buf;
    l->automaton.next = views[2].buf;
    l->automaton.onto = views[3].buf;
    l->automaton.along = views[4].buf;
    l->loop.controller = l->loop.samples > 0 ? &l->controller : NULL;
    l->loop.position = views[6].buf;
    l->loop.motor = views[7].buf;
    l->controller.section = views[8].buf;
    l->controller.position = views[9].buf;
    l->controller.torque = views[10].buf;
    l->loop.commands = views[11].buf;
    l->loop.ahead = views[12].buf;
    l->loop.noise = views[13].len > 0 ? views[13].buf : NULL;
    l->loop.times = views[14].buf;
    l->loop.values = views[15].buf;
}

/* Run with more and more room for segments; the caller frees run->segments and run->work. */
static jounce_status run_with_room(const Loop *l, jounce_run *run, const Py_buffer *views) {
    const jounce_automaton *a = &l->automaton;
    size_t n = (size_t)a->states, width = n + 2, kept = (size_t)views[16].len;
    double *start = malloc(n * sizeof(double) + kept);
    size_t work = (size_t)JOUNCE_AUTOMATON_WORK(a->states, a->moving, a->modes, a->guards);
    jounce_status status = JOUNCE_RANGE;
    run->work = malloc(work * sizeof(double));
    if (run->work != NULL && start != NULL) {
        memcpy(start, run->z, n * sizeof(double));
        memcpy(start + n, views[16].buf, kept);
        jounce_prepare(run);
        do {
            free(run->segments);
            run->segments = malloc(run->room * width * sizeof(double));
            if (run->segments == NULL) {
                break;
            }
            memcpy(run->z, start, n * sizeof(double));
            memcpy(views[16].buf, start + n, kept);
            run->mode = l->mode;
            run->count = 0;
            status = jounce_run_loop(&l->loop, run, views[16].buf, views[17].buf);
            run->room *= 2;
        } while (status == JOUNCE_FULL && run->room < MOST_SEGMENTS);
    }
    free(start);
    return status;
}

static size_t room_for(const Loop *l) {
    double steps = l->loop.duration / l->steps[1];
    double wanted = 1024.0 + 1.1 * (steps < 1e6 ? steps : 1e6) + 2.0 * l->loop.settings +
                    2.0 * l->loop.samples;
    return (size_t)wanted;
}

/* An array (count, width) of what a run has put down. */
static PyObject *segments_of(State *state, const jounce_run *run, int width) {
    PyObject *result, *shape = Py_BuildValue("(ni)", (Py_ssize_t)run->count, width);
    Py_buffer view;
    if (shape == NULL) {
        return NULL;
    }
    result = PyObject_CallFunctionObjArgs(state->empty, shape, NULL);
    Py_DECREF(shape);
    if (result == NULL || !look(result, &view, WRITE)) {
        Py_XDECREF(result);
        return NULL;
    }
    memcpy(view.buf, run->segments, run->count * (size_t)width * sizeof(double));
    PyBuffer_Release(&view);
    return result;
}

/* One of the loops that run_loops is given, and what comes of it. */
typedef struct {
    Loop loop;
    jounce_run run;
    jounce_status status;
    Py_buffer views[LOOP_ARRAYS];
} Lane;

/* Read numbers, controller and arrays out of a tuple; `lane` stays where it is. */
static int read_lane(PyObject *given, Lane *lane) {
    double numbers[LOOP_NUMBERS], controller[CONTROLLER_NUMBERS];
    PyObject *parts[2 + LOOP_ARRAYS];
    Loop *l = &lane->loop;
    int i;
    if (!PyTuple_Check(given) || PyTuple_Size(given) != 2 + LOOP_ARRAYS) {
        PyErr_SetString(PyExc_TypeError, "expected tuples (numbers, controller, 18 arrays)");
        return 0;
    }
    for (i = 0; i < 2 + LOOP_ARRAYS; i++) {
        parts[i] = PyTuple_GetItem(given, i);
    }
    if (plain_numbers(parts[0], numbers, LOOP_NUMBERS) != LOOP_NUMBERS ||
        plain_numbers(parts[1], controller, CONTROLLER_NUMBERS) != CONTROLLER_NUMBERS) {
        if (!PyErr_Occurred()) {
            PyErr_SetString(PyExc_ValueError, "too few numbers");
        }
        return 0;
    }
    read_numbers(l, numbers);
    read_controller(&l->controller, controller);
    if (!loop_makes_sense(l) || !look_into_loop(parts + 2, l, lane->views)) {
        return 0;
    }
    point_into(l, lane->views);
    lane->run.automaton = &l->automaton;
    lane->run.steps[0] = l->steps[0];
    lane->run.steps[1] = l->steps[1];
    lane->run.z = lane->views[5].buf;
    lane->run.room = room_for(l);
    return 1;
}

static void clear_lanes(Lane *lanes, Py_ssize_t count) {
    Py_ssize_t i;
    for (i = 0; i < count; i++) {
        free(lanes[i].run.segments);
        free(lanes[i].run.work);
        release(lanes[i].views, LOOP_ARRAYS);
    }
    PyMem_Free(lanes);
}

/* A list of (segments, status), one of each lane. */
static PyObject *outcomes_of(State *state, const Lane *lanes, Py_ssize_t count) {
    PyObject *list = PyList_New(count);
    Py_ssize_t i;
    for (i = 0; i < count && list != NULL; i++) {
        const Lane *lane = &lanes[i];
        PyObject *segments = lane->run.segments == NULL
                                 ? PyErr_NoMemory()
                                 : segments_of(state, &lane->run, lane->loop.automaton.states + 2);
        PyObject *pair = segments == NULL ? NULL : Py_BuildValue("(Ni)", segments, lane->status);
        if (pair == NULL || PyList_SetItem(list, i, pair) < 0) {
            Py_CLEAR(list);
        }
    }
    return list;
}

static PyObject *run_loops(PyObject *module, PyObject *const *args, Py_ssize_t given) {
    PyObject *result;
    Py_ssize_t count, i, read = 0;
    Lane *lanes;
    if (!expect(given, 1, "run_loops(loops)")) {
        return NULL;
    }
    if (!PyTuple_Check(args[0])) {
        PyErr_SetString(PyExc_TypeError, "expected a tuple of tuples");
        return NULL;
    }
    count = PyTuple_Size(args[0]);
    lanes = PyMem_Calloc((size_t)count + 1, sizeof *lanes);
    if (lanes == NULL) {
        return PyErr_NoMemory();
    }
    while (read < count && read_lane(PyTuple_GetItem(args[0], read), &lanes[read])) {
        read += 1;
    }
    if (read < count) {
        clear_lanes(lanes, read);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    for (i = 0; i < count; i++) {
        lanes[i].status = run_with_room(&lanes[i].loop, &lanes[i].run, lanes[i].views);
    }
    Py_END_ALLOW_THREADS
    result = outcomes_of(PyModule_GetState(module), lanes, count);
    clear_lanes(lanes, count);
    return result;
}

static PyObject *balance(PyObject *module, PyObject *const *args, Py_ssize_t given) {
    Py_buffer views[2];
    Py_ssize_t n;
    (void)module;
    if (!expect(given, 2, "balance(matrix, scale)") || !look(args[1], &views[1], WRITE)) {
        return NULL;
    }
    n = items(&views[1]);
    PyBuffer_Release(&views[1]);
    {
        const Wanted wanted[2] = {room(args[0], n * n), room(args[1], n)};
        if (n > 10000 || !look_into(wanted, 2, views)) {
            return PyErr_Occurred() ? NULL
                                    : PyErr_Format(PyExc_ValueError, "a matrix of order %zd", n);
        }
    }
    jounce_balance(views[0].buf, views[1].buf, (int)n);
    release(views, 2);
    Py_RETURN_NONE;
}

/* --- messages of FMUs (binding_fmi2.c) ---------------------------------------------------------- */

static PyObject *fmi2_logger(PyObject *module, PyObject *strays) {
    void *note = PyLong_AsVoidPtr(strays);
    (void)module;
    if (note == NULL) {
        return PyErr_Occurred() ? NULL : PyErr_Format(PyExc_ValueError, "strays: no address");
    }
    return PyLong_FromVoidPtr((void *)jounce_fmi2_log_to((jounce_fmi2_note)note));
}

/* --- the module ------------------------------------------------------------------------------- */

static PyMethodDef functions[] = {
    {"bounds", FAST(bounds_of), METH_FASTCALL,
     "bounds(*bounds)\n--\n\nReturn lower bounds, upper bounds, and both in turn, of plain positive "
     "numbers, pairs and None, None at the end left out; None for anything else."},
    {"advance_lags", FAST(advance_lags), METH_FASTCALL,
     "advance_lags(lags, motion, tau, omega)\n--\n\nReturn lags a time tau after the motion had "
     "the derivatives 0, 1, … given."},
    {"move", FAST(move), METH_FASTCALL,
     "move(distance, bounds, start[, type, limits])\n--\n\nReturn the fastest Motion from rest to "
     "rest, or the status; an object of the type that holds the Motion, and the limits, where these "
     "are given."},
    {"transfer", FAST(transfer), METH_FASTCALL,
     "transfer(start, end, bounds[, type, limits])\n--\n\nReturn the fastest Motion between two "
     "states, or the status that says why there is none; an object as `move` does."},
    {"velocity_transfer", FAST(velocity_transfer), METH_FASTCALL,
     "velocity_transfer(start, end, bounds[, type, limits])\n--\n\nReturn the fastest Motion to the "
     "velocity and acceleration of `end`, or the status; an object as `move` does."},
    {"transfer_lasting", FAST(transfer_lasting), METH_FASTCALL,
     "transfer_lasting(start, end, bounds, duration[, type, limits])\n--\n\nReturn a Motion of a "
     "given duration, or the status; an object as `move` does."},
    {"possible_durations", FAST(possible_durations), METH_FASTCALL,
     "possible_durations(start, end, bounds)\n--\n\nReturn the durations that a transfer can "
     "take, as pairs (low, high); none where the end cannot be reached."},
    {"together", FAST(together), METH_FASTCALL,
     "together(transfers, type)\n--\n\nReturn objects that hold Motions, and limits, slowed down to "
     "the shortest duration that all can take, and their limits, or the status."},
    {"transfers", FAST(transfers), METH_FASTCALL,
     "transfers(order, starts, ends, bounds, durations, inside_after, statuses, counts)\n--\n\n"
     "Plan N transfers: durations and inside_after (N,), NaN where there is none, statuses and "
     "numbers of pieces (N,) int8 are put in place."},
    {"balance", FAST(balance), METH_FASTCALL,
     "balance(matrix, scale)\n--\n\nBalance a matrix (n, n) and put down the scale (n,), in place."},
    {"run_loops", FAST(run_loops), METH_FASTCALL,
     "run_loops(loops)\n--\n\nRun servo loops, each a tuple (numbers, controller, *arrays); return "
     "of each its segments (time, mode and state in a row, the last at the end) and the status. "
     "Last states, the controllers' and (e, w, u) of the samples are put in place."},
    {"fmi2_logger", fmi2_logger, METH_O,
     "fmi2_logger(strays)\n--\n\nReturn the address of a logger for FMUs of FMI 2.0, which fills "
     "in the arguments of a message and calls note(status, category, text) of the environment "
     "(FMI2_MARK, note), or of another environment the function at the address `strays`."},
    {"evaluate_lanes", FAST(evaluate_lanes), METH_FASTCALL,
     "evaluate_lanes(durations, lengths, states, end_states, times, points, first, last, out)\n"
     "--\n\nPut derivatives first to last of N motions in place, (last - first + 1, N, points), "
     "at times (points,) of all or (N, points). Durations (N,) are those of the motions, lengths "
     "(N, m) those of their pieces, states (N, m, n + 1) those at the starts of these, "
     "end_states (N, n + 1)."},
    {"move_durations", FAST(move_durations), METH_FASTCALL,
     "move_durations(order, distances, lower, upper, durations)\n--\n\nPut the durations of N moves "
     "of order 1 to 3 in place, NaN where there is none. Distances are (N,), lower and upper bounds "
     "tuples of arrays (N,), or those of one for all; lower ones are None where they are those of "
     "the upper with the other sign."},
    {"move_pieces", FAST(move_pieces), METH_FASTCALL,
     "move_pieces(order, distances, starts, bounds, most, lengths, states, end_states)\n--\n\nPut "
     "the pieces of N moves in place, (N, most), (N, most, order + 1) and (N, order + 1); NaN "
     "where there is none."},
    {"transfer_pieces", FAST(transfer_pieces), METH_FASTCALL,
     "transfer_pieces(order, starts, ends, bounds, most, lengths, states, end_states)\n--\n\nPut "
     "the pieces of N transfers in place, (N, most), (N, most, order + 1) and (N, order + 1); NaN "
     "where there is none."},
    {NULL, NULL, 0, NULL},
};

static int add_constants(PyObject *module) {
    return PyModule_AddIntConstant(module, "OK", JOUNCE_OK) == 0 &&
           PyModule_AddIntConstant(module, "UNREACHABLE", JOUNCE_UNREACHABLE) == 0 &&
           PyModule_AddIntConstant(module, "NO_DURATION", JOUNCE_NO_DURATION) == 0 &&
           PyModule_AddIntConstant(module, "RANGE", JOUNCE_RANGE) == 0 &&
           PyModule_AddIntConstant(module, "CHATTER", JOUNCE_CHATTER) == 0 &&
           PyModule_AddIntConstant(module, "FMI2_MARK", (long)JOUNCE_FMI2_MARK) == 0;
}

static int add_types(PyObject *module, State *state) {
    state->pieces = PyType_FromModuleAndSpec(module, &pieces_spec, NULL);
    state->motion = PyType_FromModuleAndSpec(module, &motion_spec, NULL);
    state->follower = PyType_FromModuleAndSpec(module, &follower_spec, NULL);
    return state->pieces != NULL && state->motion != NULL && state->follower != NULL &&
           PyModule_AddType(module, (PyTypeObject *)state->follower) == 0 &&
           PyModule_AddType(module, (PyTypeObject *)state->pieces) == 0 &&
           PyModule_AddType(module, (PyTypeObject *)state->motion) == 0;
}

static int execute(PyObject *module) {
    State *state = PyModule_GetState(module);
    PyObject *numpy = PyImport_ImportModule("numpy");
    if (numpy == NULL) {
        return -1;
    }
    state->empty = PyObject_GetAttrString(numpy, "empty");
    state->asarray = PyObject_GetAttrString(numpy, "asarray");
    state->ndarray = PyObject_GetAttrString(numpy, "ndarray");
    state->number = PyObject_CallMethod(numpy, "dtype", "s", "d");
    state->convert = Py_BuildValue("{ss}", "order", "C");
    state->of_motion = PyUnicode_InternFromString("_motion");
    state->of_coasting = PyUnicode_InternFromString("coasting");
    state->of_limits = PyUnicode_InternFromString("limits");
    state->of_inside_after = PyUnicode_InternFromString("inside_after");
    state->of_flat = PyUnicode_InternFromString("flat");
    Py_DECREF(numpy);
    if (state->empty == NULL || state->asarray == NULL || state->ndarray == NULL ||
        state->number == NULL || state->convert == NULL || state->of_motion == NULL ||
        state->of_coasting == NULL || state->of_limits == NULL ||
        state->of_inside_after == NULL || state->of_flat == NULL) {
        return -1;
    }
    return add_types(module, state) && add_constants(module) ? 0 : -1;
}

static int traverse(PyObject *module, visitproc visit, void *arg) {
    State *state = PyModule_GetState(module);
    Py_VISIT(state->empty);
    Py_VISIT(state->asarray);
    Py_VISIT(state->ndarray);
    Py_VISIT(state->number);
    Py_VISIT(state->convert);
    Py_VISIT(state->pieces);
    Py_VISIT(state->motion);
    Py_VISIT(state->follower);
    return 0;
}

static int clear(PyObject *module) {
    State *state = PyModule_GetState(module);
    Py_CLEAR(state->of_motion);
    Py_CLEAR(state->of_coasting);
    Py_CLEAR(state->of_limits);
    Py_CLEAR(state->of_inside_after);
    Py_CLEAR(state->of_flat);
    Py_CLEAR(state->empty);
    Py_CLEAR(state->asarray);
    Py_CLEAR(state->ndarray);
    Py_CLEAR(state->number);
    Py_CLEAR(state->convert);
    Py_CLEAR(state->pieces);
    Py_CLEAR(state->motion);
    Py_CLEAR(state->follower);
    return 0;
}

static void release_module(void *module) { clear(module); }

static PyModuleDef_Slot slots[] = {
    {Py_mod_exec, (void *)execute},
#ifdef Py_mod_gil
    {Py_mod_gil, Py_MOD_GIL_NOT_USED},
#endif
    {0, NULL},
};

static struct PyModuleDef definition = {
    .m_base = PyModuleDef_HEAD_INIT,
    .m_name = "jounce.core.binding",
    .m_doc = "The C99 core: evaluation and planning of motions with bounded derivatives.",
    .m_size = sizeof(State),
    .m_methods = functions,
    .m_slots = slots,
    .m_traverse = traverse,
    .m_clear = clear,
    .m_free = release_module,
};

PyMODINIT_FUNC PyInit_binding(void) { return PyModuleDef_Init(&definition); }
