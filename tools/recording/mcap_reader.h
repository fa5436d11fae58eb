// Reads MCAP. The file may be hostile, damaged, or still be written: what can be read is read.
//
// open() walks over the heads of all records, and reads no chunk. So it needs no summary, and the walk takes
// one look per chunk. Chunks may overlap in time, and come in any order. next() has those in memory of which
// the times overlap, but not more than a limit: beyond it, it has the next messages of each, and reads a
// chunk again when these have been returned.
#pragma once

#include <list>
#include <memory>
#include <optional>
#include <vector>

#include "tools/recording/block.h"
#include "tools/recording/file.h"
#include "tools/recording/recording.h"

namespace sft::recording {

class McapReader final : public Recording {
 public:
  /// The limits that the reader never exceeds.
  struct Limits {
    std::uint64_t chunk_bytes = std::uint64_t{1} << 30;  ///< the largest chunk when it is not compressed
    /// For the messages of all chunks that overlap. The chunk that is being read comes on top.
    std::uint64_t memory_bytes = std::uint64_t{1} << 28;
    std::uint64_t reread_bytes = std::uint64_t{1} << 36;  ///< of all chunks that are read again
    /// The largest record of a schema, channel or metadata. All definitions together have 16 times as much.
    std::uint64_t text_bytes = std::uint64_t{1} << 24;
  };

  /// Errc::malformed if the file does not begin like MCAP.
  static Result<std::unique_ptr<McapReader>> open(File file, const Limits& limits);
  static Result<std::unique_ptr<McapReader>> open(File file) { return open(std::move(file), Limits()); }

  std::string format() const override;
  const Overview& overview() override;
  void rewind(std::uint64_t from_ns, const std::set<std::uint16_t>* only) override;
  std::optional<Message> next() override;
  void read_attachments(const std::function<void(const Bytes&)>& each) override;
  void check() override;

 private:
  struct Statistics {
    std::uint64_t messages = 0;
    std::uint32_t chunks = 0;
    std::uint64_t first_ns = 0, last_ns = 0;
    std::map<std::uint16_t, std::uint64_t> of_channel{};
  };
  struct Footer {
    std::uint64_t summary = 0;
    std::uint32_t crc = 0;
  };
  /// The records that the walk over the file found.
  struct Found {
    std::string profile{}, library{};
    std::vector<Place> places{};               ///< by their first time once the walk is over
    std::map<std::uint64_t, Place> indexed{};  ///< what chunk indexes say, by offset
    std::vector<std::pair<std::uint64_t, std::uint64_t>> attachments{};  ///< their offsets and lengths
    std::optional<Statistics> statistics{};
    std::optional<Footer> footer{};
    std::uint64_t data_end = 0;  ///< the offset of the record; 0: there is none
    std::uint32_t data_crc = 0;
    bool has_summary_channels = false;
  };

  McapReader(File file, const Limits& limits) : file_(std::move(file)), limits_(limits) {}
  void scan();
  bool scan_from(std::uint64_t offset, std::uint64_t end);
  bool scan_record(Opcode opcode, std::uint64_t offset, std::uint64_t length);
  void scan_content(Opcode opcode, std::uint64_t offset, std::span<const std::byte> content);
  bool scan_chunk(std::uint64_t offset, std::uint64_t length);
  void add_to_run(std::uint64_t offset, std::uint64_t length);
  void add_chunk_index(ByteReader from);
  void add_statistics(ByteReader from);
  void go_on_by_index();
  std::string name(Opcode opcode, std::uint64_t offset) const;

  std::optional<Bytes> bytes_of_place(const Place& place);
  std::optional<Block> opened(const Place& place);
  void open_due_blocks();
  bool reopen(Block& block);
  void keep_within_memory(const Block& in_use);
  void count();

  void check_place(const Place& place, std::map<std::uint16_t, std::uint64_t>& counted);
  void check_indexes(const Place& place, const Bytes& bytes, std::uint64_t messages);
  void check_summary(const std::map<std::uint16_t, std::uint64_t>& counted);
  void check_crc(const char* what, std::uint64_t begin, std::uint64_t end, std::uint32_t crc);

  File file_;
  Limits limits_;
  Found found_{};
  Overview overview_{};
  bool is_counted_ = false;
  std::uint64_t definition_bytes_ = 0;  ///< of schemas and channels

  // The state of next().
  std::list<Block> open_{};
  std::size_t next_place_ = 0;
  std::uint64_t reread_ = 0;  ///< the bytes of the chunks that were read again
  std::uint64_t from_ns_ = 0;
  std::optional<std::set<std::uint16_t>> only_{};
  std::list<Block>::iterator given_ = open_.end();  ///< the block of the message that next() returned last
};

}  // namespace sft::recording
