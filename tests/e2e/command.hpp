// The real `cylpose` command as a child process.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace cylpose {

struct CommandResult {
  int exit_code;  ///< 128 + signal when a signal ended it
  std::string out;
  std::string err;
};

/// `cylpose` with arguments, started at once. Standard output and error go to files in `folder`.
class RunningCommand {
 public:
  /// `stdout_path`: where standard output goes instead of the file that wait() reads.
  RunningCommand(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                 const std::string& stdout_path = {});
  ~RunningCommand();
  RunningCommand(const RunningCommand&) = delete;
  RunningCommand& operator=(const RunningCommand&) = delete;

  void send(int signal) const;
  CommandResult wait();

 private:
  std::filesystem::path out_, err_;
  int pid_ = -1;  ///< -1 when it has been waited for
};

inline CommandResult run_cylpose(const std::vector<std::string>& arguments, const std::filesystem::path& folder) {
  return RunningCommand(arguments, folder).wait();
}

}  // namespace cylpose
