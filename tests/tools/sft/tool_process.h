// The command sft in a process of its own.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

namespace sft::test {

struct Ended {
  int code = -1;  ///< exit code, or minus the signal that ended it
  std::string out;
  std::string err;
};

class ToolProcess {
 public:
  /// With a terminal of 80 x 24 as its standard input and output, or with pipes, or with pipes and a standard
  /// output that is full.
  enum class On { pipes, terminal, full_disk };
  explicit ToolProcess(std::vector<std::string> arguments, On on = On::pipes);
  ~ToolProcess();
  ToolProcess(const ToolProcess&) = delete;
  ToolProcess& operator=(const ToolProcess&) = delete;

  /// Reads until it has printed that to its standard output; false if it ended first.
  bool prints(std::string_view expected);
  void press(std::string_view keys) const;
  /// To its standard input, where that is no terminal. Returns when it has read that, or nearly, or has
  /// ended.
  void feed(std::string_view text) const;
  void end_input();
  void send(int signal) const;
  void close_output();
  Ended end();
  const std::string& out() const { return ended_.out; }
  /// Returns true if the terminal echoes.
  bool echoes() const;

 private:
  bool read_some();

  pid_t process_ = -1;
  int in_ = -1;  ///< where that is no terminal
  int out_ = -1;
  int err_ = -1;
  int terminal_ = -1;   ///< the user's end
  int other_end_ = -1;  ///< the program's, kept open
  Ended ended_;
};

/// Runs the tool until it ends by itself. `input` is everything on its standard input.
Ended run_tool(std::vector<std::string> arguments, std::string_view input = {});

}  // namespace sft::test
