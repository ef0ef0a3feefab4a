#!/bin/sh
# Stands for gcc: counts branches, and moves the notes of the compiler to where the counts will be.
for word in "$@"; do
  case "$word" in -fsyntax-only | --version | c++) exec "$REAL_GCC" "$@" ;; esac
done
# What a sanitizer adds are branches of its own: it is left out.
for word in "$@"; do
  shift
  case "$word" in -fsanitize=* | -fno-sanitize-recover=*) ;; *) set -- "$@" "$word" ;; esac
done
"$REAL_GCC" "$@" --coverage -O0 -fprofile-abs-path -fkeep-inline-functions "-DSMG_INLINE=static inline" || exit
out=a.out before=
for word in "$@"; do
  [ "$before" = -o ] && out=$word
  before=$word
done
from=$(cd "$(dirname "$out")" && pwd)
mkdir -p "$GCOV_PREFIX$from"
for notes in "$from"/*.gcno; do
  [ -e "$notes" ] && mv "$notes" "$GCOV_PREFIX$from/"
done
exit 0
