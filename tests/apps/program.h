// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Runs the built program, whose path the macro STILLRAY_PROGRAM holds, as a user would.
#pragma once

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace stillray {

/// A folder of its own under the system's temporary one, removed with everything in it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "stillray-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) {
      throw std::runtime_error("no temporary folder could be made: " + name);
    }
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

struct ProgramRun {
  int exit_code = -1;  ///< -1: ended by a signal
  std::string output;
  std::string errors;
};

inline std::string ReadText(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// Names of the files in a folder.
inline std::set<std::string> FilesIn(const std::string& folder) {
  std::set<std::string> names;
  for (const std::filesystem::directory_entry& entry :
       std::filesystem::directory_iterator(folder)) {
    names.insert(entry.path().filename().string());
  }
  return names;
}

/// The program with its output and errors going to files.
class StartedProgram {
 public:
  /// `stdout_path`, `stderr_path`: where its output and errors go instead of into the result.
  explicit StartedProgram(std::vector<std::string> arguments, std::string stdout_path = "",
                          std::string stderr_path = "")
      : keeps_output_(stdout_path.empty()),
        keeps_errors_(stderr_path.empty()),
        out_(keeps_output_ ? folder_ / "out" : std::move(stdout_path)),
        err_(keeps_errors_ ? folder_ / "err" : std::move(stderr_path)) {
    arguments.insert(arguments.begin(), STILLRAY_PROGRAM);
    std::vector<char*> argv;
    for (std::string& argument : arguments) {
      argv.push_back(argument.data());
    }
    argv.push_back(nullptr);
    constexpr int kFlags = O_WRONLY | O_CREAT | O_TRUNC;
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out_.c_str(), kFlags, 0600);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err_.c_str(), kFlags, 0600);
    const int error =
        posix_spawn(&child_, STILLRAY_PROGRAM, &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) {
      throw std::runtime_error("could not be started: " STILLRAY_PROGRAM);
    }
  }

  void Signal(int number) const { kill(child_, number); }

  ProgramRun Wait() const {
    int state = 0;
    if (waitpid(child_, &state, 0) != child_) {
      throw std::runtime_error("could not be waited for: " STILLRAY_PROGRAM);
    }
    return {WIFEXITED(state) ? WEXITSTATUS(state) : -1,
            keeps_output_ ? ReadText(out_) : std::string(),
            keeps_errors_ ? ReadText(err_) : std::string()};
  }

 private:
  TemporaryFolder folder_;
  bool keeps_output_;
  bool keeps_errors_;
  std::string out_;
  std::string err_;
  pid_t child_ = 0;
};

/// Runs the program to its end. `stdout_path`, `stderr_path`: as for StartedProgram.
inline ProgramRun RunProgram(std::vector<std::string> arguments,
                             const std::string& stdout_path = "",
                             const std::string& stderr_path = "") {
  return StartedProgram(std::move(arguments), stdout_path, stderr_path).Wait();
}

/// Starts the program, sends it Ctrl-C once a file is there (after half a minute in any case), and
/// waits for its end.
inline ProgramRun InterruptProgram(std::vector<std::string> arguments,
                                   const std::string& wait_for) {
  const StartedProgram program(std::move(arguments));
  for (int i = 0; i < 30000 && !std::filesystem::exists(wait_for); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  program.Signal(SIGINT);
  return program.Wait();
}

}  // namespace stillray
