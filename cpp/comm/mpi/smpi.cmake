# SimGrid's SMPI instead of MPI: ranks, messages and time are simulated in one process. Its compiler wrapper is not
# needed: it only adds these paths, and macros for malloc and sleep that C++ code does without.
if(MOTES_PYTHON)
  message(FATAL_ERROR "MOTES_MPI=smpi needs MOTES_PYTHON=OFF: a simulator runs programs, not Python")
endif()
find_path(SMPI_INCLUDE smpi/smpi.h REQUIRED)
find_library(SIMGRID_LIBRARY simgrid REQUIRED)
add_library(MPI::MPI_C INTERFACE IMPORTED)
target_include_directories(MPI::MPI_C INTERFACE ${SMPI_INCLUDE} ${SMPI_INCLUDE}/smpi)
target_link_libraries(MPI::MPI_C INTERFACE ${SIMGRID_LIBRARY})
get_filename_component(MOTES_PROGRAM_RPATH "${SIMGRID_LIBRARY}" DIRECTORY)
message(STATUS "Simulated MPI: ${SIMGRID_LIBRARY}")

# smpirun loads a program as a library, once for each rank.
function(motes_program target)
  target_compile_options(${target} PRIVATE -fPIC)
  target_link_options(${target} PRIVATE -shared -Wl,-z,defs)
endfunction()
