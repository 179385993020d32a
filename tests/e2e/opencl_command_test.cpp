// The command on OpenCL devices.
#include <gmock/gmock.h>

#include <cstdlib>
#include <string>

#include "scene.hpp"

namespace cylpose {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using OpenclCommand = SceneTest;

constexpr int kUnusableInput = 2;
constexpr int kDeviceMissing = 4;

TEST_F(OpenclCommand, DevicesListsThemWithWhatMattersAndTheChoice) {
  const CommandResult result = run({"devices"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, testing::ContainsRegex("\n  opencl +OpenCL "));
  EXPECT_THAT(result.out, AllOf(HasSubstr("\n  0  "), HasSubstr(" units, "), HasSubstr("; driver "),
                                testing::ContainsRegex("\nselected.*: [0-9]+ \\(")));
}

TEST_F(OpenclCommand, EstimatesTheVerySamePosesAndTimesTheKernels) {
  write_frames(2);
  const CommandResult serial = estimate({path("frames"), "--backend", "serial"});
  const CommandResult opencl = estimate({path("frames"), "--device", "0", "--timing"});
  ASSERT_EQ(opencl.exit_code, 0) << opencl.err;
  EXPECT_EQ(opencl.out, serial.out);
  for (const char* stage : {"\ngate ", "\nopening ", "\nedges ", "\nlocate "}) {
    EXPECT_THAT(opencl.err, HasSubstr(stage));
  }
}

// Sets a variable for the commands that a test starts.
class ScopedVariable {
 public:
  ScopedVariable(const char* name, const char* value) : name_(name) { setenv(name, value, 1); }
  ~ScopedVariable() { unsetenv(name_); }
  ScopedVariable(const ScopedVariable&) = delete;
  ScopedVariable& operator=(const ScopedVariable&) = delete;

 private:
  const char* name_;
};

TEST_F(OpenclCommand, IsTheDefaultWhereThereIsADevice) {
  write_frames(1);
  const CommandResult result = estimate({path("frames"), "--timing"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("\nopening ")) << "the kernels' times";
}

TEST_F(OpenclCommand, WithoutAnyDeviceSerialDoesItAndTheUserIsToldOnce) {
  write_frames(2);
  const CommandResult with_device = estimate({path("frames")});
  const ScopedVariable no_drivers("OCL_ICD_VENDORS", path("no-drivers").c_str());
  const CommandResult without = estimate({path("frames")});
  ASSERT_EQ(without.exit_code, 0) << without.err;
  EXPECT_EQ(without.out, with_device.out);
  const std::string note = "no usable OpenCL device found; the serial backend";
  EXPECT_THAT(without.err, HasSubstr(note));
  EXPECT_EQ(without.err.find(note), without.err.rfind(note));
  EXPECT_EQ(estimate({path("frames"), "--backend", "opencl"}).exit_code, kDeviceMissing);
}

TEST_F(OpenclCommand, ADeviceThatTheEnvironmentAsksForMustExist) {
  write_frames(1);
  const ScopedVariable device("CYLPOSE_DEVICE", "abacus");
  const CommandResult result = estimate({path("frames")});
  EXPECT_EQ(result.exit_code, kUnusableInput);
  EXPECT_THAT(result.err, AllOf(HasSubstr("'abacus'"), HasSubstr("CYLPOSE_DEVICE")));
}

TEST_F(OpenclCommand, ADeviceThatIsNotThereOrHasNoUseIsRefused) {
  write_frames(1);
  const CommandResult missing = estimate({path("frames"), "--device", "abacus"});
  EXPECT_EQ(missing.exit_code, kUnusableInput);
  EXPECT_THAT(missing.err, AllOf(HasSubstr("'abacus'"), HasSubstr("device 0 ")));
  const CommandResult useless = estimate({path("frames"), "--device", "0", "--backend", "serial"});
  EXPECT_EQ(useless.exit_code, kUnusableInput);
  EXPECT_THAT(useless.err, HasSubstr("--backend serial"));
}

}  // namespace
}  // namespace cylpose
