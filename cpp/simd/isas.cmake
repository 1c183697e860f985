# Which instruction sets the kernels are compiled for: MOTES_BUILT_ISAS, narrowest first, and what each needs.
set(MOTES_ISAS "all" CACHE STRING
  "Instruction sets of the kernels: all; runnable: those of this processor; widest: this processor's widest alone")
set_property(CACHE MOTES_ISAS PROPERTY STRINGS all runnable widest)
if(NOT MOTES_ISAS MATCHES "^(all|runnable|widest)$")
  message(FATAL_ERROR "MOTES_ISAS must be all, runnable or widest, got ${MOTES_ISAS}")
endif()

# With BMI2, which processors with AVX2 also have, shifts by a variable take one operation instead of three.
set(MOTES_FLAGS_avx2 -mavx2 -mbmi2)
set(MOTES_FLAGS_avx512 -mbmi2 -mavx512f -mavx512dq -mavx512vl -mavx512bw)
set(MOTES_LANES_sse2 4)
set(MOTES_LANES_avx2 8)
set(MOTES_LANES_avx512 16)
set(MOTES_LANES_neon 4)

# If there is nothing to choose from, sse2 is the name of the portable build of four lanes.
set(MOTES_BUILT_ISAS sse2)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64" AND NOT MOTES_GENERIC)
  list(APPEND MOTES_BUILT_ISAS avx2 avx512)
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "aarch64|arm64" AND NOT MOTES_GENERIC)
  set(MOTES_BUILT_ISAS neon)  # which all of these processors have
endif()
if(NOT MOTES_ISAS STREQUAL "all")
  execute_process(COMMAND ${CMAKE_CXX_COMPILER} -march=native -dM -E -x c++ /dev/null
    OUTPUT_VARIABLE native COMMAND_ERROR_IS_FATAL ANY)
  foreach(isa IN LISTS MOTES_BUILT_ISAS)
    foreach(flag IN LISTS MOTES_FLAGS_${isa})
      string(REGEX REPLACE "^-m" "" feature ${flag})
      string(TOUPPER ${feature} feature)
      if(NOT native MATCHES "__${feature}__")
        list(REMOVE_ITEM MOTES_BUILT_ISAS ${isa})
      endif()
    endforeach()
  endforeach()
  if(MOTES_ISAS STREQUAL "widest")
    list(GET MOTES_BUILT_ISAS -1 MOTES_BUILT_ISAS)
  endif()
endif()

# Written to headers instead of flags: files that include neither are the same in all builds, so ccache compiles them
# once.
file(CONFIGURE OUTPUT cpp/generated/simd/generic.h CONTENT "#pragma once\n#cmakedefine MOTES_GENERIC\n" @ONLY)
set(tables "")
set(compiled "")
foreach(isa sse2 avx2 avx512 neon)
  if(isa IN_LIST MOTES_BUILT_ISAS)
    list(APPEND tables "&motes::${isa}::table")
    list(APPEND compiled true)
  else()
    list(APPEND tables "nullptr")
    list(APPEND compiled false)
  endif()
endforeach()
list(JOIN tables ", " tables)
list(JOIN compiled ", " compiled)
file(CONFIGURE OUTPUT cpp/generated/simd/builds.h CONTENT
"#pragma once
// `table` of each build, by Isa; null where there is none.
#define MOTES_BUILDS(table) {@tables@}
#define MOTES_COMPILED {@compiled@}
" @ONLY)
