// The messages of one chunk, or of a piece of a file without chunks, in the order of their log times.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "tools/recording/mcap.h"

namespace sft::recording {

/// The place of a chunk, or of a run of records that are in no chunk.
struct Place {
  std::uint64_t offset = 0;       ///< of the record of the chunk, or of the first record of the run
  std::uint64_t data_offset = 0;  ///< of the bytes with the records
  std::uint64_t data_bytes = 0;   ///< their length in the file
  std::uint64_t size = 0;         ///< their length when they are not compressed
  std::uint64_t first_ns = 0;     ///< the earliest log time
  std::uint64_t last_ns = 0;
  std::uint32_t crc = 0;  ///< of the bytes when they are not compressed; 0: none
  bool is_chunk = false;
  std::string compression{};
  std::uint64_t index_end = 0;         ///< the end of the message indexes behind the chunk
  std::set<std::uint16_t> channels{};  ///< of which it has messages; empty: not known
};

/// The functions that a walk through records calls. A fault ends the walk.
struct RecordVisitor {
  std::function<void(Opcode, std::span<const std::byte>, std::uint64_t offset)> record;
  std::function<void(std::uint64_t offset, const std::string& what)> fault;
};

/// Walks through records, which are complete in `bytes`. Offsets are those within `bytes`.
void walk(std::span<const std::byte> bytes, const RecordVisitor& visitor);

/// Reads the content of a message record; false: it is too short.
bool read_message(std::span<const std::byte> content, Message& message);

/// Messages of a place, from `before` on: all, or as many as memory is for.
struct Block {
  /// A message by its time and the offset of its record.
  struct Entry {
    std::uint64_t log_ns;
    std::uint64_t offset;
  };

  const Place* place = nullptr;
  Bytes bytes{};
  std::vector<Entry> entries{};
  std::size_t at = 0;         ///< the next entry
  std::uint64_t before = 0;   ///< messages of the place that come before these entries
  bool has_rest = false;      ///< others come behind them
  std::uint64_t rest_ns = 0;  ///< the time of the first of the others

  bool is_empty() const { return at == entries.size(); }
  std::uint64_t time() const { return is_empty() ? rest_ns : entries[at].log_ns; }
  std::uint64_t memory() const { return bytes.size() + entries.size() * sizeof(Entry); }
  /// Keeps the next messages that have room in `most` bytes, and at least `least` of them.
  void shorten(std::uint64_t most, std::size_t least);
};

}  // namespace sft::recording
