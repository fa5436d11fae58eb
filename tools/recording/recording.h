// The interface for reading a recording: its channels, and its messages in the order of their log times.
// There are implementations for MCAP and for the SQLite files of rosbag2.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tools/recording/mcap.h"

namespace sft::recording {

/// The contents of a recording in numbers, from its summary or from counting its messages.
struct Overview {
  std::uint64_t messages = 0;
  std::uint64_t first_ns = 0;  ///< the log time of the first message; 0: there is none
  std::uint64_t last_ns = 0;
  std::map<std::uint16_t, std::uint64_t> of_channel{};  ///< the number of messages of each channel
  std::map<std::string, std::uint64_t> chunks{};        ///< the number of chunks with each compression
  std::map<std::string, Texts> metadata{};              ///< the last metadata record of each name
  std::map<std::string, std::uint64_t> attachments{};   ///< sizes by name
};

class Recording {
 public:
  virtual ~Recording() = default;

  /// Returns "MCAP" or "rosbag2 (SQLite)", followed by the profile and the name of the writer if the file
  /// has them.
  virtual std::string format() const = 0;
  /// Returns the overview. Counts the messages if the file does not have their number.
  virtual const Overview& overview() = 0;
  /// Starts reading at the first message that was logged at `from_ns` or later. Only messages of the
  /// channels in `only` are read; null: messages of all channels.
  virtual void rewind(std::uint64_t from_ns = 0, const std::set<std::uint16_t>* only = nullptr) = 0;
  /// Returns the next message, or nothing after the last message. Its data are valid until the next call.
  /// Messages that cannot be read are skipped, and faults() reports them.
  virtual std::optional<Message> next() = 0;
  /// Calls `each` with the contents of the attachment records that can be read.
  virtual void read_attachments(const std::function<void(const Bytes&)>& each) { (void)each; }
  /// Reads the whole file, and compares its indexes and statistics with its records. Differences are
  /// faults.
  virtual void check() = 0;
  /// Sets a function that long operations call from time to time. If it returns true, the operation ends
  /// early and adds a fault about this.
  void set_is_stopped(std::function<bool()> is_stopped) { is_stopped_ = std::move(is_stopped); }

  const std::map<std::uint16_t, Schema>& schemas() const { return schemas_; }
  const std::map<std::uint16_t, Channel>& channels() const { return channels_; }
  /// Returns the faults that were found so far, each once, such as "Chunk at offset 4711: its checksum is
  /// wrong; it is left out".
  const std::vector<std::string>& faults() const { return faults_; }

 protected:
  void add(Schema schema, const std::string& where);
  void add(Channel channel, const std::string& where);
  void add_fault(std::string fault);
  bool is_stopped();

  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, Channel> channels_;

 private:
  std::vector<std::string> faults_;
  std::function<bool()> is_stopped_;
};

}  // namespace sft::recording
