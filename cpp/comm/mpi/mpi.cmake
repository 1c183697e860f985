# Defines MOTES_MPI_ABIS, MOTES_PROGRAM_RPATH and motes_program().
if(MOTES_MPI STREQUAL "smpi")
  include(${CMAKE_CURRENT_LIST_DIR}/smpi.cmake)
  return()
endif()

# Adds what a standalone program needs beyond linking: nothing with a real MPI.
function(motes_program target)
endfunction()

# No MPI is needed to build: the calls are compiled once per ABI, and find their functions when the program runs.
set(MOTES_MPI_ABIS openmpi mpich standard)
set(MOTES_PROGRAM_RPATH "$ORIGIN/../lib")  # an environment's own libmpi, from its bin

# The environment variable MPICC chooses a site's own MPI, whose library is then looked for first.
if(DEFINED ENV{MPICC})
  find_program(MPI_C_COMPILER "$ENV{MPICC}" REQUIRED)
  find_package(MPI REQUIRED COMPONENTS C)
  list(GET MPI_C_LIBRARIES 0 library)
  file(REAL_PATH "${library}" MOTES_SITE_MPI)
  message(STATUS "MPI of ${MPI_C_COMPILER}: ${MOTES_SITE_MPI}")
  get_filename_component(folder "${library}" DIRECTORY)
  list(PREPEND MOTES_PROGRAM_RPATH ${folder})
endif()
