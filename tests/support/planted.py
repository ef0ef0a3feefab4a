"""Generated C with many faults planted in one library, each switched on at run time.

    subject = Planted(spec)
    subject.fault = "no compensation"

A fault is a pattern of the emitted text and what stands there instead; `planted` is its number, 0 for none.
"""
import ctypes
import functools
import re
import tempfile
from pathlib import Path

import numpy as np

from smidgen.build import binary
from smidgen.build.binary import REALS, SHARED, Built, compile_shared, find_compiler, write_files
from smidgen.compile.emit.emit import generate
from smidgen.run.step.integrator import Integrator
from smidgen.run.step.prepared import prepare, scene_of
from smidgen.check.verify.subject import Emitted

METHOD = "spherical-midpoint"
TURN, CAP = 1e-9, 1e-6          # angle of a turned state; relative error of an increment within the cap
AREA = 0.05                     # of the sphere, that the cap covers: z > 1 - 2 AREA

HEAD = """
int planted = 0;
double planted_axis[3] = {0, 0, 1};
int64_t planted_step = -1;
static void planted_turn(smg_real *w, int64_t count) {
  const smg_real x = w[0], y = w[1], z = w[2];
  if (planted != %(turned)d || count != planted_step) return;
  w[0] += (smg_real)%(TURN)g * (2 * z - 3 * y);
  w[1] += (smg_real)%(TURN)g * (3 * x - z);
  w[2] += (smg_real)%(TURN)g * (y - 2 * x);
}
static smg_real planted_cap(smg_real x, smg_real y, smg_real z) {
  const smg_real along = (smg_real)planted_axis[0] * x + (smg_real)planted_axis[1] * y + (smg_real)planted_axis[2] * z;
  return planted == %(cap)d && along > (smg_real)%(EDGE)g * SMG_MATH(sqrt)(x * x + y * y + z * z) ? 1 + (smg_real)%(CAP)g : 1;
}
"""
# where steps go by rows: the same faults in slots, the increment by its field
ROWS = """static void planted_turn_slot(smg_real *w, int64_t pitch, int64_t count) {
  smg_real first[3] = {w[0], w[pitch], w[2 * pitch]};
  planted_turn(first, count);
  for (int k = 0; k < 3; ++k) w[k * pitch] = first[k];
}
static void planted_cap_lanes(const smg_lanes *m, smg_lanes *g) {
  for (int lane = 0; lane < SMG_LANES && planted == %(cap)d; ++lane) {
    const smg_real part = planted_cap(smg_lane_get(m, lane), smg_lane_get(m + 1, lane), smg_lane_get(m + 2, lane));
    for (int k = 0; k < 3; ++k) ((smg_real *)(g + k))[lane] *= part;
  }
}
static void planted_cap_slots(const smg_turning turn, int64_t slot, smg_lanes *g) {
  smg_lanes m[3];
  smg_take_slots(turn.m, turn.pitch, slot, m);
  planted_cap_lanes(m, g);
}
"""
# name -> (pattern, replacement) of the emitted text; @ is the number of the fault
FAULTS = {
    "no compensation": [(r"  smg_vec_store\(compensation, (.*)\);", r"  if (planted != @) smg_vec_store(compensation, \1);"),
                 (r"(?<=\) )smg_add_compensated\(w \+ k, compensation \+ k, u\[k\]\);",
                  r"{ if (planted == @) w[k] += u[k]; else smg_add_compensated(w + k, compensation + k, u[k]); }"),
                 (r"smg_lane_put\(to \+ k \* pitch, carried\);", r"smg_lane_put(to + k * pitch, planted == @ ? smg_lane_of(0) : carried);")],
    "no branch check": [(r"if \((!smg_clear_of_branches\(n\.det\) .*)\) return SMG_WRONG_BRANCH;", r"if (planted != @ && (\1)) return SMG_WRONG_BRANCH;"),
                        (r": certified \? SMG_OK : SMG_WRONG_BRANCH;", r": certified || planted == @ ? SMG_OK : SMG_WRONG_BRANCH;"),
                        (r"status == SMG_OK && sure\)", r"status == SMG_OK && (sure || planted == @))")],
    "turned": [(r"\+\+s->count;(?! /\*)", r"++s->count; planted_turn(s->w, s->count);"),
               (r"(smg_solve_rows\(.*\);\n *if \(status == SMG_OK\) \+\+s->count;) planted_turn\(s->w, s->count\);",
                r"\1 planted_turn_slot(s->row_w, smg_pitch(&s->c), s->count);")],
    "cap": [(r"smg_scale\(u, (smg_h_over_kappa\(c, k, h\)), 3\);", r"smg_scale(u, planted_cap(m[0], m[1], m[2]) * \1, 3);"),
            (r"(smg_precess\(turn, slot, w, g\);\n)(?=  if \(SMG_ONTO_LEAF\) smg_lane_along_spin)", r"\1  planted_cap_slots(turn, slot, g);\n"),
            (r"(smg_lane_scale\(u, smg_lane_of\(2 \* turn\.half\), 3\);)", r"\1\n  planted_cap_lanes(m, u);"),
            (r"smg_vec smg_motion(\(const .*?smg_vec m\) \{.*?\n\}\n)",
             r"smg_vec smg_right_motion\1SMG_INLINE smg_vec smg_motion(const smg_coefficients *c, smg_vec m) { return "
             r"smg_vec_scale(planted_cap(m.x, m.y, m.z), smg_right_motion(c, m)); }\n")],
    "momentum's sign": [(r"(out\[3 \* f \+ b\] = )(smg_sum_of_ranks\(&sum\);)", r"\1(planted == @ ? -1 : 1) * \2")],
    "momentum without kappa": [(r"(held\[k - from\] = smg_present\(&c, k\) \* )(smg_kappa\(&c, k\))", r"\1(planted == @ ? 1 : \2)")],
    "momentum of a family": [(r"(out\[3 \* f \+ b\] = )", r"\1f > 0 && planted == @ ? 0 : ")],
    "casimirs": [(r"(out\[k\] = smg_present\(&c, k\) \* )(smg_casimir\()", r"\1(planted == @ ? (smg_real)1.5 : 1) * \2")],
}
# of every function energy_<effect> and observe_<observable>
FUNCTION = r"(smg_real \w+_((?:energy|observe)_\w+)\(const \w+_model \*model, smg_real t, const smg_real \*w\) \{.*?)return (?:sum \+ lost|smg_sum_of\(&sum\));"


class Planted(Emitted):
    """The generated C of a spec with all the faults that find a place in it; `fault` is None at first."""

    def __init__(self, spec, values=None, solver="auto"):
        scene = scene_of(spec, None, values)
        files = generate(scene, METHOD, solver=solver, amalgamate=True)
        self.spec, self.scene, self.values, self.solver, self.files = spec, scene, values, solver, dict(files)
        source = f"{scene.name}.c"
        self.files[source], self.numbers = planted(files[source])
        self.varied, self.chosen = None, (0, -1, (0, 0, 1))

    @functools.cached_property
    def double(self):
        return self.made("double")

    @functools.cached_property
    def extended(self):
        return self.made("long double")

    def made(self, real):
        place = Path(tempfile.mkdtemp(prefix="planted-"))
        write_files(self.files, place)
        flags = (*binary.FLAGS, *SHARED, *REALS[real])
        compile_shared(place, sorted(f for f in self.files if f.endswith(".c")), find_compiler(), flags)
        built = Built(self.scene.name, place / "model.so", place, real, "cc", (), {}, "planted")
        return self.set_in(Integrator(prepare(self.spec, METHOD, None, self.values, self.solver), built))

    def outputs(self, w, t):
        """In double: one library is enough."""
        return super().outputs(w.astype(float), t)

    def switch(self, fault=None, axis=(0, 0, 1), step=-1):
        """Only this fault from now on."""
        self.chosen = self.numbers[fault] if fault else 0, step, axis / np.linalg.norm(axis)
        for one in {"double", *self.__dict__} & {"double", "extended"}:
            self.set_in(getattr(self, one))
        return self

    def set_in(self, one):
        library = ctypes.CDLL(str(one.built.binary))
        number, step, axis = self.chosen
        (ctypes.c_double * 3).in_dll(library, "planted_axis")[:] = list(map(float, axis))
        ctypes.c_int64.in_dll(library, "planted_step").value = step
        ctypes.c_int.in_dll(library, "planted").value = number
        return one

    def outputs_faults(self):
        """The names of those that change what is written."""
        return [name for name in self.numbers if name.startswith(("momentum", "casimirs", "energy_", "observe_"))]


def planted(text):
    """(text with every fault that finds a place, name -> number)."""
    numbers = {}
    for number, (name, places) in enumerate(FAULTS.items(), 1):
        for pattern, instead in places:
            if name == "momentum of a family" and "SMG_FAMILIES 1\n" in text:
                continue
            text, found = re.subn(pattern, instead.replace("@", str(number)), text, flags=re.DOTALL if ".*?" in pattern else 0)
            if found:
                numbers[name] = number

    def reversed_one(match):
        number = numbers[match[2]] = 100 + len(numbers)
        return f"{match[1]}return (planted == {number} ? -1 : 1) * smg_sum_of(&sum);"
    text = re.sub(FUNCTION, reversed_one, text, flags=re.DOTALL)
    head = HEAD % {"turned": numbers["turned"], "cap": numbers["cap"], "TURN": TURN, "CAP": CAP, "EDGE": 1 - 2 * AREA}
    text = re.sub(r"(?=SMG_INLINE void smg_end_slots\()", ROWS % numbers, text)
    place = text.index("\nstatic")         # after the includes
    return text[:place] + head + text[place:], numbers
