// The command on OpenCL devices.
#include <gmock/gmock.h>

#include <string>

#include "scene.hpp"

namespace cylpose {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using OpenclCommand = SceneTest;

constexpr int kUnusableInput = 2;

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
