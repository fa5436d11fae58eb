// The parts of a recording, with the names of MCAP (https://mcap.dev/spec). All structs are values, but the
// data of a message belong to the object that made the message.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "tools/recording/bytes.h"

namespace sft::recording {

/// The eight bytes at both ends of a file.
inline constexpr std::string_view magic = "\x89MCAP0\r\n";

/// The kinds of records.
enum class Opcode : std::uint8_t {
  header = 1,
  footer,
  schema,
  channel,
  message,
  chunk,
  message_index,
  chunk_index,
  attachment,
  attachment_index,
  statistics,
  metadata,
  metadata_index,
  summary_offset,
  data_end
};

inline constexpr std::size_t record_head_bytes = 9;    ///< the opcode, and the length of what follows
inline constexpr std::size_t message_head_bytes = 22;  ///< the size of a message record before its data

/// The definition of a message type.
struct Schema {
  std::uint16_t id = 0;
  std::string name{};      ///< "sensor_msgs/msg/Imu"
  std::string encoding{};  ///< "ros2msg" or "ros2idl"; empty: the file has no definition
  std::string data{};
  friend bool operator==(const Schema&, const Schema&) = default;
};

/// A channel has the messages of one topic and schema. In SFT's files, it also has only one publisher's
/// QoS.
struct Channel {
  std::uint16_t id = 0;
  std::uint16_t schema = 0;  ///< the id of the schema; 0: there is none
  std::string topic{};
  std::string encoding = "cdr";
  Texts metadata{};
  friend bool operator==(const Channel&, const Channel&) = default;
};

struct Message {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_ns = 0;      ///< the time of recording, by the clock of the recorder
  std::uint64_t publish_ns = 0;  ///< the time of publishing, by the clock of the publisher
  std::span<const std::byte> data{};
};

}  // namespace sft::recording
