# Writes OUTPUT: the kernel sources FILES (full paths, a list in order of use) as one C++ string with a #line directive
# before each, so that compiler messages name the real file and line, and a hash of the whole.
# Run with cmake -DOUTPUT=... -DFILES=... -P embed_kernels.cmake

set(source "")
foreach(file IN LISTS FILES)
  get_filename_component(name "${file}" NAME)
  file(READ "${file}" text)
  string(APPEND source "#line 1 \"kernels/${name}\"\n${text}")
endforeach()
string(SHA256 hash "${source}")

# Compilers limit the length of one literal, so there is one per line; they are joined by the compiler.
string(REPLACE "\\" "\\\\" source "${source}")
string(REPLACE "\"" "\\\"" source "${source}")
string(REPLACE "\n" "\\n\"\n    \"" source "${source}")

file(WRITE "${OUTPUT}.new" "// Generated from kernels/ by cmake/embed_kernels.cmake.
#include \"opencl/kernel_source.hpp\"

namespace cylpose::opencl {

const char* kernel_source() {
  return \"${source}\";
}

const char* kernel_hash() {
  return \"${hash}\";
}

}  // namespace cylpose::opencl
")
file(COPY_FILE "${OUTPUT}.new" "${OUTPUT}" ONLY_IF_DIFFERENT)
file(REMOVE "${OUTPUT}.new")
