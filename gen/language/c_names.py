"""What parameters and indices are called in C.

A word of a spec may be a macro of some header, compiler or machine, and no list of those is complete. So a name stays as it is only where
its form is not that of a macro; any other gets an underscore at its end, where a spec's names have none and macros have none either.
"""
from __future__ import annotations

import re

# J, Kx, I1, B_z: letters after a single capital. NAN, M_PIf, INT64_MAX, PRId64, FP_FAST_FMAF32x: macros have a second capital at once.
LIKE_A_MACRO = re.compile(r"[A-Z][A-Z0-9_]*[A-Z]|I\Z|B[0-9]+\Z")       # I: <complex.h>; B50: <termios.h>
# Macros in small letters: of the C library, of POSIX, and those that compilers define for a machine.
WORDS = frozenset("""
    alloca assert bool complex errno false fpclassify imaginary kill_dependency math_errhandling noreturn offsetof setjmp signbit static_assert stderr stdin
    stdout strdupa strndupa thread_local true unreachable va_arg va_copy va_end va_start makedev major minor
    linux unix i386 i486 i586 i686 arm hpux mips mipsel ppc sgi sparc sun tru64 vax win32 win64 cygwin m68k near far huge small interface pascal cdecl
    vector pixel
    """.split())
PREFIXES = re.compile(r"is[a-z]|(be|le)[0-9]+toh|hto(be|le)[0-9]|u?int(_least|_fast)?[0-9]|(atomic|memory_order|stdc|omp|ompt|mpi|fe|fp)_")

FREE_INDICES = frozenset("ijaz")     # one letter that nothing in generated code is called by


def in_c(name: str) -> str:
    """The member of the parameters that a parameter is."""
    return name + "_" if LIKE_A_MACRO.match(name) or name in WORDS or PREFIXES.match(name) else name


def index_in_c(name: str) -> str:
    """The variable that counts an index: apart from those of the generated code itself, none of which ends in an underscore."""
    return name if name in FREE_INDICES else name + "_"
