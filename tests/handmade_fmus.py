"""Small FMUs written by hand in XML and C: honest, odd and malicious ones."""

import hashlib
import subprocess
import tempfile
import zipfile
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from xml.sax.saxutils import quoteattr

import fmpy

HEADERS = Path(fmpy.__file__).parent / "c-code"
TOKEN = "{handmade}"
FIRST = {"input": 0, "output": 100, "parameter": 200, "local": 300, "derivative": 400}
PLATFORM = {"2.0": "linux64", "3.0": "x86_64-linux"}


@dataclass(frozen=True)
class Model:
    """A block: C code that steps it, over u[], y[], p[], x[] (doubles), t, h and settled.

    The last is noSetFMUStatePriorToCurrentPoint.
    It may return a status of FMI, or 100 for FMI 3.0's wish to end the simulation.
    """

    name: str
    inputs: tuple = ("u",)
    outputs: tuple = ("y",)
    parameters: dict = field(default_factory=dict)
    states: int = 0
    step: str = ""
    outputs_code: str = ""
    types: dict = field(default_factory=dict)
    """Types of variables that are not doubles: FMI 3.0's words."""
    derivatives_code: str = ""
    """Directional derivative, from du[] and dx[] to dy[] and dxdot[]; empty for none."""
    rollback: bool = True
    variable_step: bool = True
    step_size: float | None = 0.001
    xml: tuple = ()
    """Pairs (old, new) put into the XML after it is made."""
    prelude: str = ""
    """C code before everything else."""
    epilogue: str = ""
    """C code behind everything else."""
    code: tuple = ()
    """Pairs (old, new) put into the C source after it is made."""
    missing: str = ""
    """Function of the C source that is left out."""


INERTIA = Model(
    "plant",
    outputs=("y", "y_rate"),
    parameters={"J": 2.0},
    states=2,
    step="x[0] += h * x[1] + 0.5 * h * h * u[0] / p[0]; x[1] += h * u[0] / p[0];",
    outputs_code="y[0] = x[0]; y[1] = x[1];",
    derivatives_code="dy[0] = dx[0]; dy[1] = dx[1]; dxdot[0] = dx[1]; dxdot[1] = du[0] / p[0];",
)

PD = Model(
    "controller",
    inputs=("r", "y", "y_rate"),
    outputs=("u",),
    parameters={"kp": 4.0, "kd": 2.0},
    step="y[0] = p[0] * (u[0] - u[1]) - p[1] * u[2];",
)


def fmu(folder, model=INERTIA, version="2.0", *, binary=True, name=None, extra=()):
    """Write an FMU of a model into a folder, and return its path."""
    entries = [("modelDescription.xml", description(model, version).encode())]
    if binary:
        suffix = f"{PLATFORM[version]}/{model.name}.so"
        entries.append((f"binaries/{suffix}", _library(_source(model, version))))
    entries.append(("sources/model.c", _source(model, version).encode()))
    return archive(Path(folder) / (name or f"{model.name}_{version[0]}.fmu"), [*entries, *extra])


def archive(path, entries):
    """Write a zip archive of (name or ZipInfo, bytes), in this order, duplicates and all."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, data in entries:
            packed.writestr(name, data)
    return path


def description(model, version):
    """Return the modelDescription.xml of a model."""
    text = (_xml2 if version == "2.0" else _xml3)(model)
    for old, new in model.xml:
        assert old in text, f"{old} not in {text}"
        text = text.replace(old, new)
    return text


def variables(model):
    """Return (name, value reference, causality, start) of each variable, in order."""
    rows = [(n, FIRST["input"] + i, "input", 0.0) for i, n in enumerate(model.inputs)]
    rows += [(n, FIRST["output"] + i, "output", None) for i, n in enumerate(model.outputs)]
    rows += [
        (n, FIRST["parameter"] + i, "parameter", start)
        for i, (n, start) in enumerate(model.parameters.items())
    ]
    if model.derivatives_code:
        rows += [(f"x{i}", FIRST["local"] + i, "local", None) for i in range(model.states)]
        rows += [
            (f"der(x{i})", FIRST["derivative"] + i, "derivative", None) for i in range(model.states)
        ]
    return rows


def _flags(model, last_letter):
    can = str(model.rollback).lower()
    plural = "s" if last_letter == "S" else ""
    return (
        f'modelIdentifier="{model.name}" canGetAndSetFMU{last_letter}tate="{can}" '
        f'canHandleVariableCommunicationStepSize="{str(model.variable_step).lower()}" '
        f'providesDirectionalDerivative{plural}="{str(bool(model.derivatives_code)).lower()}"'
    )


def _experiment(model):
    return "" if model.step_size is None else f'<DefaultExperiment stepSize="{model.step_size!r}"/>'


def _xml2(model):
    rows = variables(model)
    kinds = {"Int32": "Integer", "Boolean": "Boolean"}
    lines = []
    for name, reference, causality, start in rows:
        kind = kinds.get(model.types.get(name), "Real")
        shown = {"Integer": lambda x: str(int(x)), "Boolean": lambda x: str(bool(x)).lower()}
        given = "" if start is None else f' start="{shown.get(kind, repr)(start)}"'
        of = ""
        if causality == "derivative":
            causality = "local"
            of = f' derivative="{1 + next(i for i, r in enumerate(rows) if r[0] == name[4:-1])}"'
        variability = "tunable" if causality == "parameter" else "continuous"
        if kind != "Real" and causality != "parameter":
            variability = "discrete"
        lines.append(
            f'<ScalarVariable name={quoteattr(name)} valueReference="{reference}" '
            f'causality="{causality}" variability="{variability}"><{kind}{given}{of}/>'
            "</ScalarVariable>"
        )
    places = {
        kind: [i for i, row in enumerate(rows, start=1) if row[2] == kind]
        for kind in ("output", "derivative")
    }
    unknowns = {
        kind: "".join(f'<Unknown index="{i}"/>' for i in found) for kind, found in places.items()
    }
    derivatives = f"<Derivatives>{unknowns['derivative']}</Derivatives>"
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<fmiModelDescription fmiVersion="2.0" modelName="{model.name}" guid="{TOKEN}" '
        'generationTool="by hand">'
        f"<CoSimulation {_flags(model, 's')}/>{_experiment(model)}"
        f"<ModelVariables>{''.join(lines)}</ModelVariables>"
        f"<ModelStructure><Outputs>{unknowns['output']}</Outputs>"
        f"{derivatives if places['derivative'] else ''}</ModelStructure></fmiModelDescription>"
    )


def _xml3(model):
    rows = variables(model)
    lines = []
    for name, reference, causality, start in rows:
        kind = model.types.get(name, "Float64")
        given = "" if start is None else f' start="{start!r}"'
        if kind == "Boolean" and start is not None:
            given = f' start="{str(bool(start)).lower()}"'
        if "Int" in kind and start is not None:
            given = f' start="{int(start)}"'
        if causality == "derivative":
            causality = "local"
            given = f' derivative="{FIRST["local"] + reference - FIRST["derivative"]}"'
        variability = "tunable" if causality == "parameter" else "continuous"
        if kind != "Float64" and causality != "parameter":
            variability = "discrete"
        lines.append(
            f'<{kind} name={quoteattr(name)} valueReference="{reference}" '
            f'causality="{causality}" variability="{variability}"{given}/>'
        )
    structure = "".join(
        f'<Output valueReference="{r}"/>' for _, r, causality, _ in rows if causality == "output"
    ) + "".join(
        f'<ContinuousStateDerivative valueReference="{r}"/>'
        for _, r, causality, _ in rows
        if causality == "derivative"
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<fmiModelDescription fmiVersion="3.0" modelName="{model.name}" '
        f'instantiationToken="{TOKEN}" generationTool="by hand">'
        f"<CoSimulation {_flags(model, 'S')}/>{_experiment(model)}"
        f"<ModelVariables>{''.join(lines)}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )


@cache
def _library(source):
    """Return the bytes of a shared library, compiled once per source."""
    with tempfile.TemporaryDirectory() as folder:
        code, library = Path(folder) / "model.c", Path(folder) / "model.so"
        code.write_text(source)
        command = ["cc", "-std=c99", "-shared", "-fPIC", "-ffp-contract=off", "-w"]
        subprocess.run(
            [*command, f"-I{HEADERS}", str(code), "-o", str(library), "-lm"],
            check=True, capture_output=True,
        )  # fmt: skip
        return library.read_bytes()


def sha256(path):
    """Return the digest of a file."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def _source(model, version):
    head = f"""
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#define FMI {version[0]}
#define TOKEN "{TOKEN}"
enum {{ NU = {max(len(model.inputs), 1)}, NY = {max(len(model.outputs), 1)},
       NP = {max(len(model.parameters), 1)}, NX = {max(model.states, 1)} }};
typedef struct {{
    double u[NU], y[NY], p[NP], x[NX], t;
}} State;
static void defaults(State *s) {{
    memset(s, 0, sizeof *s);
    {" ".join(f"s->p[{i}] = {start!r};" for i, start in enumerate(model.parameters.values()))}
}}
static void show(State *s) {{
    double *u = s->u, *y = s->y, *p = s->p, *x = s->x; {model.outputs_code}
}}
static int advance(State *s, double h, int settled) {{
    double *u = s->u, *y = s->y, *p = s->p, *x = s->x, t = s->t; {model.step}
    s->t += h; show(s);
    return 0;
}}
static void slope(State *s, const double *du, const double *dx, double *dy, double *dxdot) {{
    double *u = s->u, *p = s->p, *x = s->x; {model.derivatives_code}
}}
"""
    head += model.prelude
    body = _COMMON + (_FMI2 if version == "2.0" else _FMI3)
    if model.missing:
        assert model.missing in body
        body = body.replace(f" {model.missing}(", f" left_out_{model.missing}(")
    for old, new in model.code:
        assert old in body, f"{old} not in {body}"
        body = body.replace(old, new)
    return head + body + model.epilogue


_COMMON = r"""
#if FMI == 2
#include "fmi2Functions.h"
#else
#include "fmi3Functions.h"
#endif
typedef struct Instance_ Instance;
static double *at(State *s, unsigned vr) {
    if (vr < NU) return s->u + vr;
    if (vr >= 100 && vr < 100 + NY) return s->y + vr - 100;
    if (vr >= 200 && vr < 200 + NP) return s->p + vr - 200;
    if (vr >= 300 && vr < 300 + NX) return s->x + vr - 300;
    return 0;
}
static int sensitivities(State *s, const unsigned *un, size_t nu, const unsigned *kn, size_t nk,
                         const double *seed, double *out) {
    double du[NU] = {0}, dx[NX] = {0}, dy[NY] = {0}, dxdot[NX] = {0};
    for (size_t i = 0; i < nk; i++) {
        if (kn[i] < NU) du[kn[i]] = seed[i]; else dx[kn[i] - 300] = seed[i];
    }
    slope(s, du, dx, dy, dxdot);
    for (size_t i = 0; i < nu; i++)
        out[i] = un[i] >= 400 ? dxdot[un[i] - 400] : dy[un[i] - 100];
    return 0;
}
"""

_FMI2 = r"""
struct Instance_ { State s; fmi2CallbackFunctions call; char *name; };
#define S(c) (&((Instance *)c)->s)
static fmi2Status fail(fmi2Component c, const char *text) {
    Instance *i = c;
    i->call.logger(i->call.componentEnvironment, i->name, fmi2Error, "error", text);
    return fmi2Error;
}
const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String where,
    const fmi2CallbackFunctions *call, fmi2Boolean visible, fmi2Boolean logging) {
    if (strcmp(guid, TOKEN)) {
        call->logger(call->componentEnvironment, name, fmi2Error, "error", "wrong guid");
        return 0;
    }
    Instance *i = call->allocateMemory(1, sizeof *i);
    i->call = *call;
    i->name = strcpy(call->allocateMemory(strlen(name) + 1, 1), name);
    defaults(&i->s);
    return i;
}
void fmi2FreeInstance(fmi2Component c) {
    Instance *i = c;
    i->call.freeMemory(i->name);
    i->call.freeMemory(i);
}
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String k[]) {
    return fmi2OK;
}
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real tol, fmi2Real start,
    fmi2Boolean e, fmi2Real stop) { S(c)->t = start; return fmi2OK; }
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    if (S(c)->p[0] < -1e6) return fail(c, "parameter too small");
    show(S(c));
    return fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2Reset(fmi2Component c) { defaults(S(c)); return fmi2OK; }
#define GET(T, N) fmi2Status fmi2Get##N(fmi2Component c, const fmi2ValueReference v[], size_t n, \
    T out[]) { for (size_t i = 0; i < n; i++) { double *a = at(S(c), v[i]); \
    if (!a) return fail(c, "no such variable"); out[i] = (T)*a; } return fmi2OK; }
#define SET(T, N) fmi2Status fmi2Set##N(fmi2Component c, const fmi2ValueReference v[], size_t n, \
    const T in[]) { for (size_t i = 0; i < n; i++) { double *a = at(S(c), v[i]); \
    if (!a) return fail(c, "no such variable"); *a = in[i]; } return fmi2OK; }
GET(fmi2Real, Real) GET(fmi2Integer, Integer) GET(fmi2Boolean, Boolean)
SET(fmi2Real, Real) SET(fmi2Integer, Integer) SET(fmi2Boolean, Boolean)
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean n) {
    for (int i = 0; i < NU; i++)
        if (!isfinite(S(c)->u[i])) return fail(c, "input is not finite");
    if (fabs(t - S(c)->t) > 1e-9 * (1 + fabs(t))) return fail(c, "wrong communication point");
    return advance(S(c), h, n);
}
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *out) {
    if (!*out) *out = malloc(sizeof(State));
    *(State *)*out = *S(c);
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate in) {
    *S(c) = *(State *)in;
    return fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *in) {
    free(*in);
    *in = 0;
    return fmi2OK;
}
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference un[], size_t nu,
    const fmi2ValueReference kn[], size_t nk, const fmi2Real seed[], fmi2Real out[]) {
    return sensitivities(S(c), un, nu, kn, nk, seed, out);
}
"""

_FMI3 = r"""
struct Instance_ { State s; fmi3LogMessageCallback log; void *env; };
#define S(c) (&((Instance *)c)->s)
static fmi3Status fail(fmi3Instance c, const char *text) {
    Instance *i = c;
    i->log(i->env, fmi3Error, "error", text);
    return fmi3Error;
}
const char *fmi3GetVersion(void) { return "3.0"; }
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String where,
    fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
    const fmi3ValueReference needed[], size_t n, fmi3InstanceEnvironment env,
    fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update) {
    if (strcmp(token, TOKEN)) { log(env, fmi3Error, "error", "wrong token"); return 0; }
    Instance *i = calloc(1, sizeof *i);
    i->log = log;
    i->env = env;
    defaults(&i->s);
    return i;
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String k[]) {
    return fmi3OK;
}
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean d, fmi3Float64 tol,
    fmi3Float64 start, fmi3Boolean e, fmi3Float64 stop) { S(c)->t = start; return fmi3OK; }
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    if (S(c)->p[0] < -1e6) return fail(c, "parameter too small");
    show(S(c));
    return fmi3OK;
}
fmi3Status fmi3Terminate(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3Reset(fmi3Instance c) { defaults(S(c)); return fmi3OK; }
#define GET(T, N) fmi3Status fmi3Get##N(fmi3Instance c, const fmi3ValueReference v[], size_t n, \
    T out[], size_t m) { for (size_t i = 0; i < n; i++) { double *a = at(S(c), v[i]); \
    if (!a) return fail(c, "no such variable"); \
    for (size_t k = 0; k < m / n; k++) out[i * (m / n) + k] = (T)a[k]; } return fmi3OK; }
#define SET(T, N) fmi3Status fmi3Set##N(fmi3Instance c, const fmi3ValueReference v[], size_t n, \
    const T in[], size_t m) { for (size_t i = 0; i < n; i++) { double *a = at(S(c), v[i]); \
    if (!a) return fail(c, "no such variable"); \
    for (size_t k = 0; k < m / n; k++) a[k] = in[i * (m / n) + k]; } return fmi3OK; }
GET(fmi3Float64, Float64) GET(fmi3Float32, Float32) GET(fmi3Int32, Int32) GET(fmi3Boolean, Boolean)
SET(fmi3Float64, Float64) SET(fmi3Float32, Float32) SET(fmi3Int32, Int32) SET(fmi3Boolean, Boolean)
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean n,
    fmi3Boolean *events, fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *last) {
    for (int i = 0; i < NU; i++)
        if (!isfinite(S(c)->u[i])) return fail(c, "input is not finite");
    if (fabs(t - S(c)->t) > 1e-9 * (1 + fabs(t))) return fail(c, "wrong communication point");
    *events = *end = *early = 0;
    *last = t + h;
    int status = advance(S(c), h, n);
    *end = status == 100;
    if (*end && S(c)->t > t) *last = S(c)->t;
    return status == 100 ? fmi3OK : status;
}
fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *out) {
    if (!*out) *out = malloc(sizeof(State));
    *(State *)*out = *S(c);
    return fmi3OK;
}
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState in) {
    *S(c) = *(State *)in;
    return fmi3OK;
}
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *in) {
    free(*in);
    *in = 0;
    return fmi3OK;
}
fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference un[], size_t nu,
    const fmi3ValueReference kn[], size_t nk, const fmi3Float64 seed[], size_t ns,
    fmi3Float64 out[], size_t no) {
    return sensitivities(S(c), un, nu, kn, nk, seed, out);
}
"""
