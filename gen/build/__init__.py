"""Stage `build`: C to a shared library from the cache, or to sources that other programs link."""
from .binary import (FLAGS, LIBRARY, Built, build_library, compile_shared, compiler_version, digest, find_compiler,
                     generator_digest, generator_name)

__all__ = ["FLAGS", "LIBRARY", "Built", "build_library", "compile_shared", "compiler_version", "digest", "find_compiler",
           "generator_digest", "generator_name"]
