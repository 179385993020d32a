# Runs the tests of TESTS (filter FILTER) in Oclgrind, which checks every access of every work-item, and fails when a
# test does or when Oclgrind has anything to report: accesses out of bounds, races, wrong calls.
#
# No --uninitialized: Oclgrind 21.10 reports every vector whose lanes are reordered, and all memory behind
# CL_MEM_USE_HOST_PTR. No optimisation or inlining: it does not know all that clang then writes.

set(log "${WORK_DIR}/oclgrind.log")
file(REMOVE_RECURSE "${WORK_DIR}")
file(MAKE_DIRECTORY "${WORK_DIR}")
# Binaries of a simulator are not to be kept.
set(ENV{XDG_CACHE_HOME} "${WORK_DIR}/cache")
execute_process(
  COMMAND "${OCLGRIND}" --data-races --check-api --log "${log}"
          --build-options "-cl-opt-disable -DCYL_INLINE=static" "${TESTS}" "--gtest_filter=${FILTER}"
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(EXISTS "${log}")
  file(READ "${log}" report)
endif()
if(NOT result EQUAL 0 OR NOT "${report}" STREQUAL "" OR NOT output MATCHES "Oclgrind Simulator")
  message(FATAL_ERROR "result: ${result}\n${report}\n${output}")
endif()
