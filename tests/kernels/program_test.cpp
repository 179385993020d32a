#include "opencl/program.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cylpose/error.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "host/temp_dir.hpp"
#include "opencl/device_list.hpp"
#include "opencl/kernel_source.hpp"

namespace cylpose::opencl {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class Programs : public ::testing::Test {
 protected:
  Programs() {
    const LocalDevice device = std::move(chosen_devices("0").at(0));
    cl_int code = CL_SUCCESS;
    context_ = Context(clCreateContext(nullptr, 1, &device.id, nullptr, nullptr, &code));
    check(code, "clCreateContext", device.info.name);
    target_ = {context_.get(), device.id, device.info.name, "identity"};
  }

  Context context_;
  ProgramTarget target_;
};

std::string build_error(const ProgramTarget& target, const std::string& source, const std::string& options) {
  try {
    static_cast<void>(built_from_source(target, source.c_str(), options));
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kDevice);
    return error.what();
  }
  return "no error";
}

TEST_F(Programs, ABuildThatFailsNamesCallDeviceOptionsFileAndLine) {
  std::string source = kernel_source();
  const std::string target_line = "CYL_KERNEL void opening(";
  const std::size_t at = source.find(target_line);
  ASSERT_NE(at, std::string::npos);
  source.insert(at, "int broken(void) { return undeclared_name; }\n");
  EXPECT_THAT(
      build_error(target_, source, build_options({})),
      AllOf(HasSubstr("clBuildProgram"), HasSubstr("CL_BUILD_PROGRAM_FAILURE"), HasSubstr(target_.device_name),
            HasSubstr("-DCYL_GROUP_SIZE=1"), HasSubstr("undeclared_name"), HasSubstr("kernels/morphology.cl:")));
}

TEST_F(Programs, TheKernelsBuildWithoutAWarningInEveryFormat) {
  for (const PixelFormat format : {PixelFormat::kBgr8, PixelFormat::kRgb8, PixelFormat::kGray8}) {
    KernelParameters parameters;
    parameters.format = format;
    EXPECT_EQ(build_error(target_, kernel_source(), build_options(parameters) + " -Werror"), "no error");
  }
  EXPECT_EQ(build_error(target_, kernel_source(), "-cl-std=CL1.2"), "no error") << "the defaults of all parameters";
}

std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  return files;
}

TEST_F(Programs, AreKeptOnDiskAndFoundByTheirKey) {
  const TempDir folder;
  const ProgramCache cache(folder.path() / "new");
  static_cast<void>(built_kernels(target_, {}, &cache));
  ASSERT_EQ(files_in(folder.path() / "new").size(), 1U);
  const std::string key = target_.identity + "\n" + kernel_hash() + "\n" + build_options({});
  EXPECT_TRUE(cache.find(key).has_value());
  EXPECT_FALSE(cache.find(key + " ").has_value());

  KernelParameters other;
  other.format = PixelFormat::kGray8;
  static_cast<void>(built_kernels(target_, other, &cache));
  EXPECT_EQ(files_in(folder.path() / "new").size(), 2U);
  const Program from_disk = built_kernels(target_, {}, &cache);
  cl_int code = CL_SUCCESS;
  const Kernel kernel(clCreateKernel(from_disk.get(), "gate", &code));
  EXPECT_EQ(code, CL_SUCCESS);
}

TEST_F(Programs, ADamagedFileOrABinaryTheDriverRefusesIsBuiltAnew) {
  const TempDir folder;
  const ProgramCache cache(folder.path());
  static_cast<void>(built_kernels(target_, {}, &cache));
  const std::filesystem::path file = files_in(folder.path()).at(0);
  const std::string key = target_.identity + "\n" + kernel_hash() + "\n" + build_options({});
  const auto whole = std::filesystem::file_size(file);
  for (const auto size : {std::uintmax_t{0}, std::uintmax_t{5}, whole / 2, whole - 1}) {
    std::filesystem::resize_file(file, size);
    EXPECT_FALSE(cache.find(key).has_value()) << size;
  }
  EXPECT_TRUE(static_cast<bool>(built_kernels(target_, {}, &cache)));
  EXPECT_EQ(std::filesystem::file_size(file), whole);

  cache.store(key, {'n', 'o', 't', ' ', 'a', ' ', 'p', 'r', 'o', 'g', 'r', 'a', 'm'});
  ASSERT_TRUE(cache.find(key).has_value());
  EXPECT_TRUE(static_cast<bool>(built_kernels(target_, {}, &cache)));
}

TEST_F(Programs, AFolderThatCannotBeWrittenCostsOnlyTime) {
  const ProgramCache cache("/proc/no/such/folder");
  EXPECT_TRUE(static_cast<bool>(built_kernels(target_, {}, &cache)));
}

}  // namespace
}  // namespace cylpose::opencl
