// Reads the messages of several recordings in the order of their log times. A thread reads ahead.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tools/recording/recording.h"

namespace sft::tool {

class PlayedFiles {
 public:
  struct Message {
    std::size_t file = 0;
    recording::Message message{};  ///< a message whose data are in `data`
    std::vector<std::byte> data{};
  };

  /// REQUIRES: there is at least one file.
  explicit PlayedFiles(std::vector<std::unique_ptr<recording::Recording>> files);
  ~PlayedFiles();
  PlayedFiles(const PlayedFiles&) = delete;
  PlayedFiles& operator=(const PlayedFiles&) = delete;

  /// Returns a file. The caller may use it only before start() and after stop().
  recording::Recording& file(std::size_t i) { return *files_[i]; }
  std::size_t size() const { return files_.size(); }

  /// Starts to read messages from this time on for next(). `only` has the channels to read of each file.
  void start(std::uint64_t from_ns, const std::vector<std::set<std::uint16_t>>& only);
  void stop();
  /// Returns the next message; nothing after the last message.
  std::optional<Message> next();

  /// Calls `each` for the messages before this time, in their order. Must not be called between start() and
  /// stop().
  template <class Each>
  void for_each_before(std::uint64_t end_ns, const std::vector<std::set<std::uint16_t>>& only,
                       const Each& each) {
    rewind(0, only);
    while (std::optional<Message> message = read()) {
      if (message->message.log_ns >= end_ns) return;
      each(*std::move(message));
    }
  }

 private:
  void rewind(std::uint64_t from_ns, const std::vector<std::set<std::uint16_t>>& only);
  std::optional<Message> read();
  void run();

  std::vector<std::unique_ptr<recording::Recording>> files_;
  std::vector<std::optional<recording::Message>> heads_{};  ///< the next message of each file

  std::mutex mutex_;
  std::condition_variable changed_;
  // The following members are guarded by the mutex.
  std::deque<Message> ahead_{};
  std::uint64_t ahead_bytes_ = 0;
  bool at_end_ = false;
  bool stops_ = false;

  std::thread thread_{};
};

}  // namespace sft::tool
