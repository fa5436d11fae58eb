// The command sft in a separate process.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

namespace sft::test {

struct Ended {
  int code = -1;  ///< the exit code, or minus the signal that ended the process
  std::string out;
  std::string err;
};

class ToolProcess {
 public:
  /// The standard input and output of the command: pipes, a terminal of 80 x 24, or pipes with a full disk in
  /// place of the standard output.
  enum class On { pipes, terminal, full_disk };
  explicit ToolProcess(std::vector<std::string> arguments, On on = On::pipes);
  ~ToolProcess();
  ToolProcess(const ToolProcess&) = delete;
  ToolProcess& operator=(const ToolProcess&) = delete;

  /// Reads until the command has printed the text to its standard output. Returns false if the command has
  /// ended without printing it.
  bool prints(std::string_view expected);
  /// Does the same for the standard error.
  bool says(std::string_view expected);
  void press(std::string_view keys) const;
  /// Writes to the standard input of the command, which must not be a terminal. Returns when the command has
  /// read nearly all of the text, or has ended.
  void feed(std::string_view text) const;
  void end_input();
  void send(int signal) const;
  void close_output();
  Ended end();
  const std::string& out() const { return ended_.out; }
  /// Returns true if the terminal echoes input.
  bool echoes() const;
  pid_t id() const { return process_; }

 private:
  bool read_some();

  pid_t process_ = -1;
  int in_ = -1;  ///< the command's input; not used if standard input is a terminal
  int out_ = -1;
  int err_ = -1;
  int terminal_ = -1;   ///< the user's end of the terminal
  int other_end_ = -1;  ///< the command's end of the terminal, kept open
  Ended ended_;
};

/// Runs the command until it ends by itself. `input` is its whole standard input.
Ended run_tool(std::vector<std::string> arguments, std::string_view input = {});

}  // namespace sft::test
