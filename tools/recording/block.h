// The messages of one chunk, or of a piece of a file without chunks, in the order of their log times.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "tools/recording/mcap.h"

namespace sft::recording {

/// The place of a chunk, or of a run of consecutive records that are in no chunk.
struct Place {
  std::uint64_t offset = 0;       ///< the offset of the chunk's record, or of the first record of the run
  std::uint64_t data_offset = 0;  ///< the offset of the bytes with the records
  std::uint64_t data_bytes = 0;   ///< the length of these bytes in the file
  std::uint64_t size = 0;         ///< the length of these bytes when they are not compressed
  std::uint64_t first_ns = 0;     ///< the earliest log time
  std::uint64_t last_ns = 0;
  std::uint32_t crc = 0;  ///< the checksum of the uncompressed bytes; 0: there is none
  bool is_chunk = false;
  std::string compression{};
  std::uint64_t index_end = 0;         ///< the end of the message indexes after the chunk
  std::set<std::uint16_t> channels{};  ///< the channels of its messages; empty: not known
};

/// The functions that walk() calls. After the first fault, the walk ends.
struct RecordVisitor {
  std::function<void(Opcode, std::span<const std::byte>, std::uint64_t offset)> record;
  std::function<void(std::uint64_t offset, const std::string& what)> fault;
};

/// Visits the records in `bytes`, all of which are complete. Offsets are relative to the first of the
/// bytes.
void walk(std::span<const std::byte> bytes, const RecordVisitor& visitor);

/// Reads the content of a message record. Returns false if the content is too short.
bool read_message(std::span<const std::byte> content, Message& message);

/// The messages of a place after its first `before` messages: all of them, or as many as fit into the
/// memory.
struct Block {
  /// A message by its time and the offset of its record.
  struct Entry {
    std::uint64_t log_ns;
    std::uint64_t offset;
  };

  const Place* place = nullptr;
  Bytes bytes{};
  std::vector<Entry> entries{};
  std::size_t at = 0;         ///< the index of the next entry
  std::uint64_t before = 0;   ///< the number of messages of the place before these entries
  bool has_rest = false;      ///< true: the place has further messages after these entries
  std::uint64_t rest_ns = 0;  ///< the log time of the first of the further messages

  bool is_empty() const { return at == entries.size(); }
  std::uint64_t time() const { return is_empty() ? rest_ns : entries[at].log_ns; }
  std::uint64_t memory() const { return bytes.size() + entries.size() * sizeof(Entry); }
  /// Keeps only the next messages: as many as fit into `most` bytes, but at least `least` messages.
  void shorten(std::uint64_t most, std::size_t least);
};

}  // namespace sft::recording
