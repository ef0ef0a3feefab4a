"""Which words may name things in a spec."""
from __future__ import annotations

import re

from ..language import limits
from ..language import codes
from ..language.expr import DRAWS
from ..language.harmonics import NORMS
from .problems import Problems
from .source import Span

IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z", re.ASCII)

FUNCTIONS = frozenset(
    "dot cross triple norm vec sqrt exp log sin cos tan asin acos atan atan2 "
    "sinh cosh tanh abs min max floor mod if".split())
# functions whose names stay free: they are meant where arguments follow
PLACE = "r"
UNRESERVED = frozenset((*DRAWS, *NORMS, PLACE))
CONSTANTS = frozenset(("t", "pi"))
GRAMMAR = frozenset("and or not of on periodic open".split())
C_WORDS = frozenset("""
    auto break case char const continue default do double else enum extern float for goto
    if inline int long register restrict return short signed sizeof static struct switch
    typedef union unsigned void volatile while
    alignas alignof asm bool catch char8_t char16_t char32_t class compl concept const_cast
    consteval constexpr constinit co_await co_return co_yield decltype delete dynamic_cast
    explicit export false friend mutable namespace new noexcept nullptr operator override
    final private protected public reinterpret_cast requires static_assert static_cast
    template this thread_local throw true try typeid typename typeof using virtual wchar_t
    and_eq bitand bitor not_eq or_eq xor xor_eq
    errno NULL NAN INFINITY HUGE_VAL EOF assert main offsetof stdin stdout stderr
    linux unix i386 FILE
    int8_t int16_t int32_t int64_t uint8_t uint16_t uint32_t uint64_t size_t ssize_t
    ptrdiff_t intptr_t uintptr_t time_t double_t float_t
    M_PI M_E DBL_EPSILON LDBL_EPSILON DBL_MAX DBL_MIN
    malloc calloc realloc free exit abort memcpy memset memmove printf
    cbrt ceil round trunc rint fabs fmod fmin fmax pow hypot log2 log10 log1p exp2 expm1
    asinh acosh atanh erf erfc gamma lgamma tgamma j0 j1 jn y0 y1 yn fma ldexp frexp modf
    isnan isinf isfinite signbit copysign nextafter remainder signgam
    """.split()) - {"gamma", "j0", "j1", "jn", "y0", "y1", "yn"}
PYTHON_WORDS = frozenset("None True False def lambda import from pass del is in as with "
                         "yield raise global nonlocal except finally await async elif".split())
# A model NAME is NAME.h: a header of this name would hide that of a C library, of POSIX or of a compiler, or be hidden by it.
HEADERS = frozenset("""
    smidgen
    assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign stdarg stdatomic stdbit stdbool
    stdckdint stddef stdint stdio stdlib stdnoreturn string tgmath threads time uchar wchar wctype
    aio cpio dirent dlfcn fcntl fmtmsg fnmatch ftw glob grp iconv langinfo libgen libintl monetary mqueue ndbm netdb nl_types poll pthread
    pwd regex sched search semaphore spawn strings stropts syslog tar termios trace ulimit unistd utime utmpx wordexp
    alloca byteswap elf endian envz argz err error execinfo features fpu_control getopt ieee754 link malloc mcheck memory mntent obstack paths
    printf resolv stdc_predef sysexits tgkill uio unwind values varargs
    cpuid emmintrin immintrin mm_malloc mmintrin pmmintrin smmintrin tmmintrin wmmintrin x86intrin xmmintrin arm_neon altivec
    mpi omp ompt quadmath windows winsock availability targetconditionals
    """.split())
# Its functions are NAME_init, ..: these are functions of a C library already.
SYMBOLS = frozenset("aio cnd mtx sem fanotify inotify res regex".split())
SYMBOL_PREFIXES = ("pthread_", "posix_spawn", "inet6_", "omp_", "mpi_")
DECLARED = ("parameter", "formula", "family of vectors")
NEVER_SPOKEN = ("model", "effect", "observable")                # in no formula
OUTSIDE = ("run", "start", "lattice", "graph", "bond list")     # never a word of the C
OUTPUTS = ("states", "energy", "momentum", "casimirs")
COMPUTED = ("magnetisation", "charge")      # outputs too; an observable may have such a name, and is then meant
COLUMNS = OUTPUTS + ("time", "step", "t", "meta", "final")      # words of the output files


def article(what: str) -> str:
    """`what` with its article."""
    return ("an " if what[0] in "aeiou" else "a ") + what


def plural(count: int, what: str) -> str:
    """`1 site`, `2 sites`."""
    return f"{count} {what}{'s' * (count != 1)}"


def identifier(problems: Problems, span: Span, name: str, what: str) -> str:
    """`name` if it may name a `what`; else an error at `span`."""
    if not IDENTIFIER.match(name):
        problems.fail(codes.IDENTIFIER, span, f"`{name}` cannot name {article(what)}",
                      "a name is a letter followed by letters, digits and `_` (ASCII only)")
    if len(name) > limits.IDENTIFIER:
        problems.fail(codes.LIMIT, span, f"this name has {len(name)} characters; "
                      f"at most {limits.IDENTIFIER} are allowed", "choose a shorter name")
    if name.endswith("_") or "__" in name or name.lower().startswith("smg_"):
        problems.fail(codes.RESERVED, span, f"`{name}` cannot name {article(what)}",
                      "names that end in `_`, contain `__` or start with `smg_` are reserved for generated code")
    if what not in OUTSIDE:
        reserved(problems, span, name, what)
    if what == "model":
        of_files(problems, span, name)
    if name == "i" and what in DECLARED:
        problems.fail(codes.RESERVED, span, f"`i` cannot name {article(what)}: it counts the "
                      "sites in strengths, radii and starts", "choose another name")
    return name


def reserved(problems: Problems, span: Span, name: str, what: str) -> None:
    """Refuse the words of C, C++, Python and of the language itself."""
    spoken = frozenset() if what in NEVER_SPOKEN else FUNCTIONS | CONSTANTS | GRAMMAR
    for words, owner in ((spoken, "the formula language"),
                         (C_WORDS, "C or C++"), (PYTHON_WORDS, "Python")):
        if name in words:
            problems.fail(codes.RESERVED, span, f"`{name}` cannot name {article(what)}: "
                          f"it is a reserved word of {owner}", f"choose another name, such as `{name}0`")


def of_files(problems: Problems, span: Span, name: str) -> None:
    """Refuse a model whose files or functions would be those of something else, also where file names know no upper case."""
    small = name.lower()
    if small in HEADERS:
        problems.fail(codes.RESERVED, span, f"`{name}` cannot name a model: its file {name}.h would hide the header {small}.h", f"choose another name, such as `{name}_model`")
    if small == "smg" or small in SYMBOLS or small.startswith(SYMBOL_PREFIXES):
        owner = "smidgen's own" if small == "smg" else "those of a system library"
        problems.fail(codes.RESERVED, span, f"`{name}` cannot name a model: its functions {name}_init, .. might clash with {owner}",
                      f"choose another name, such as `model_{name}`")
