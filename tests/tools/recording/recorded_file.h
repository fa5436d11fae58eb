// Files of MCAP that tests make and damage.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/support/temporary_directory.h"
#include "tools/recording/mcap_reader.h"
#include "tools/recording/mcap_writer.h"
#include "tools/recording/open_recording.h"

namespace sft::recording {

/// A message as a test remembers it.
struct Kept {
  std::uint16_t channel;
  std::uint32_t sequence;
  std::uint64_t log_ns;
  std::string data;
  friend bool operator==(const Kept&, const Kept&) = default;
};

inline std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

inline std::vector<Kept> all_of(Recording& from) {
  std::vector<Kept> kept;
  while (const std::optional<Message> message = from.next())
    kept.push_back({message->channel, message->sequence, message->log_ns, text_of(message->data)});
  return kept;
}

class McapFileTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name = "run.mcap") const { return (folder_.path() / name).string(); }

  McapWriter create(const McapWriter::Options& options = {}) const {
    McapWriter writer = McapWriter::create(path(), options).value();
    writer.declare(
        Schema{.id = 1, .name = "std_msgs/msg/String", .encoding = "ros2msg", .data = "string data\n"});
    for (const std::uint16_t id : {1, 2, 3})
      writer.declare(
          Channel{.id = id, .schema = 1, .topic = "/t" + std::to_string(id), .metadata = {{"k", "v"}}});
    return writer;
  }
  static void write(McapWriter& writer, const Kept& kept) {
    const Result<void> done = writer.write({.channel = kept.channel,
                                            .sequence = kept.sequence,
                                            .log_ns = kept.log_ns,
                                            .publish_ns = kept.log_ns,
                                            .data = bytes_of(kept.data)});
    ASSERT_TRUE(done) << done.error().message;
  }
  std::unique_ptr<McapReader> read(const McapReader::Limits& limits = {}) const {
    return McapReader::open(File::open(path()).value(), limits).value();
  }

  std::string content() const {
    std::ifstream file(path(), std::ios::binary);
    return {std::istreambuf_iterator(file), {}};
  }
  void replace(const std::string& content) const { std::ofstream(path(), std::ios::binary) << content; }

  test::TemporaryDirectory folder_;
};

}  // namespace sft::recording
