// Reads MCAP. The file may be hostile or damaged, or a program may still be writing it. Everything that can
// be read is read.
//
// open() reads the heads of all records, but not the contents of chunks. So it needs no summary, and reads
// only a few bytes of each chunk. Chunks may overlap in time, and may be in any order. next() keeps the
// chunks in memory that overlap in time, up to a limit. Beyond the limit, it keeps only the next messages
// of each chunk, and reads the chunk again when these messages have been returned.
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
    std::uint64_t chunk_bytes = std::uint64_t{1} << 30;  ///< the maximum size of an uncompressed chunk
    /// The limit for the messages of all chunks that overlap. The memory for the chunk that is being read
    /// is not included.
    std::uint64_t memory_bytes = std::uint64_t{1} << 28;
    /// The limit for the bytes of all chunks that are read again
    std::uint64_t reread_bytes = std::uint64_t{1} << 36;
    /// The maximum size of a record with a schema, a channel or metadata. All definitions together have at
    /// most 16 times this size.
    std::uint64_t text_bytes = std::uint64_t{1} << 24;
  };

  /// Opens the file. Returns Errc::malformed if it does not begin with the magic bytes of MCAP.
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
  /// The records that were found in the file.
  struct Found {
    std::string profile{}, library{};
    std::vector<Place> places{};  ///< the places; after the walk, they are sorted by their first times
    std::map<std::uint64_t, Place> indexed{};  ///< the contents of chunk indexes, by the offset of the chunk
    /// offsets and lengths of the attachments
    std::vector<std::pair<std::uint64_t, std::uint64_t>> attachments{};
    std::optional<Statistics> statistics{};
    std::optional<Footer> footer{};
    std::uint64_t data_end = 0;  ///< the offset of the record "data end"; 0: there is none
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

  bool knows(std::uint16_t channel);
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
  std::uint64_t definition_bytes_ = 0;  ///< the size of all schemas and channels
  bool has_all_definitions_ = false;    ///< true: the definitions of all places were read

  // The state of next().
  std::list<Block> open_{};
  std::size_t next_place_ = 0;
  std::uint64_t reread_ = 0;  ///< the size of the chunks that were read again
  std::uint64_t from_ns_ = 0;
  std::optional<std::set<std::uint16_t>> only_{};
  std::list<Block>::iterator given_ = open_.end();  ///< the block of the message that next() returned last
};

}  // namespace sft::recording
