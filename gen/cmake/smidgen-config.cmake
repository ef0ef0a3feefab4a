# find_package(smidgen) gives one function:
#
#   smidgen_add_model(TARGET SPEC file.toml [RUN name] [METHOD name] [SOLVER name] [EFFECTS a b ..] [FEATURES a b ..]
#                     [SET name=value ..] [LIBRARY folder ..] [NATIVE] [THREADS])
#
# It makes the static library TARGET of the integrator that `smidgen gen` writes for the spec; who links it includes <model>.h, where <model> is the name in the spec.
# NATIVE compiles for this processor, THREADS with OpenMP. The bits of results depend on neither. A spec that changes is generated anew.
cmake_minimum_required(VERSION 3.19)

find_program(SMIDGEN_EXECUTABLE smidgen HINTS "${CMAKE_CURRENT_LIST_DIR}/../../../bin" DOC "the command smidgen")
if(NOT SMIDGEN_EXECUTABLE)
  set(smidgen_FOUND FALSE)
  set(smidgen_NOT_FOUND_MESSAGE "the command smidgen is not on the path: set SMIDGEN_EXECUTABLE")
endif()

function(smidgen_add_model target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "NATIVE;THREADS" "SPEC;RUN;METHOD;SOLVER" "EFFECTS;FEATURES;SET;LIBRARY")
  if(arg_UNPARSED_ARGUMENTS OR NOT arg_SPEC)
    message(FATAL_ERROR "smidgen_add_model(${target}): SPEC is missing, or an argument is not known: ${arg_UNPARSED_ARGUMENTS}")
  endif()
  get_filename_component(spec "${arg_SPEC}" ABSOLUTE)
  smidgen_name_of_model(name "${spec}" "${arg_LIBRARY}")
  smidgen_words(words)
  set(folder "${CMAKE_CURRENT_BINARY_DIR}/${target}.smidgen")
  add_custom_command(
    OUTPUT "${folder}/${name}.c" "${folder}/${name}.h"
    COMMAND "${SMIDGEN_EXECUTABLE}" gen "${spec}" ${words} --amalgamate --out "${folder}"
    DEPENDS "${spec}" COMMENT "Generating the integrator ${name}" VERBATIM)
  add_library(${target} STATIC "${folder}/${name}.c")
  target_include_directories(${target} PUBLIC "${folder}")
  set_target_properties(${target} PROPERTIES C_STANDARD 11 POSITION_INDEPENDENT_CODE ON)
  smidgen_compile_as_documented()
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${spec}")
endfunction()

# The name in [model], which is that of the generated files.
function(smidgen_name_of_model name spec library)
  set(folders)
  foreach(folder IN LISTS library)
    list(APPEND folders --library "${folder}")
  endforeach()
  execute_process(COMMAND "${SMIDGEN_EXECUTABLE}" check "${spec}" --json ${folders}
                  RESULT_VARIABLE code OUTPUT_VARIABLE said ERROR_VARIABLE why)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${why}")
  endif()
  string(JSON found GET "${said}" 0 name)
  set(${name} "${found}" PARENT_SCOPE)
endfunction()

# The options of `smidgen gen`.
macro(smidgen_words words)
  set(${words} ${arg_RUN})
  foreach(word METHOD SOLVER)
    if(arg_${word})
      string(TOLOWER "${word}" option)
      list(APPEND ${words} --${option} "${arg_${word}}")
    endif()
  endforeach()
  foreach(word EFFECTS FEATURES)
    if(arg_${word})
      string(TOLOWER "${word}" option)
      list(JOIN arg_${word} "," joined)
      list(APPEND ${words} --${option} "${joined}")
    endif()
  endforeach()
  foreach(one IN LISTS arg_SET)
    list(APPEND ${words} --set "${one}")
  endforeach()
  foreach(one IN LISTS arg_LIBRARY)
    list(APPEND ${words} --library "${one}")
  endforeach()
endmacro()

# Products and sums are never fused, so that results have the same bits everywhere (linking.md, "What to know").
macro(smidgen_compile_as_documented)
  target_compile_options(${target} PRIVATE -ffp-contract=off -fno-math-errno)
  if(arg_NATIVE)
    target_compile_options(${target} PRIVATE -march=native $<$<C_COMPILER_ID:GNU>:-fno-tree-slp-vectorize>
                           $<$<AND:$<C_COMPILER_ID:GNU>,$<CONFIG:RelWithDebInfo>>:-fno-tree-vectorize>)
  endif()
  if(UNIX)
    target_link_libraries(${target} PUBLIC m)
  endif()
  if(arg_THREADS)
    find_package(OpenMP REQUIRED COMPONENTS C)
    target_link_libraries(${target} PUBLIC OpenMP::OpenMP_C)
  endif()
endmacro()
