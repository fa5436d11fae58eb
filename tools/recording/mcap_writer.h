// Writes MCAP: chunks with message indexes, a summary, statistics and checksums.
//
// In whatever way the program ends, the file is complete up to the last chunk. A failed write leaves no
// incomplete record. Each large message gets its own chunk, so that other messages can be read without
// decompressing it. Meanwhile, the chunk of the small messages stays open.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "sft/result.h"
#include "tools/recording/compression.h"
#include "tools/recording/mcap.h"

namespace sft::recording {

class McapWriter {
 public:
  struct Options {
    Compression compression = Compression::none;
    std::size_t chunk_bytes = std::size_t{1} << 20;  ///< a chunk is written once it has this size
    std::size_t large_bytes = std::size_t{1} << 18;  ///< a message of at least this size gets its own chunk
    std::string library = "sft";
  };

  /// Creates the file. The error contains its name. It is an error if the file exists.
  static Result<McapWriter> create(const std::string& path, const Options& options);
  McapWriter(McapWriter&& other) noexcept;
  McapWriter& operator=(McapWriter&&) = delete;
  ~McapWriter();  ///< if close() was not called, the file has no summary

  /// Declares a schema or a channel. It is written to the file before the first message that needs it.
  void declare(Schema schema) { schemas_[schema.id].first = std::move(schema); }
  void declare(Channel channel) { channels_[channel.id].first = std::move(channel); }
  bool has_channel(std::uint16_t id) const { return channels_.contains(id); }

  /// Appends a message of a declared channel. After an error, only close() may be called.
  Result<void> write(const Message& message);
  /// Writes the open chunk.
  Result<void> flush();
  /// Appends a metadata record.
  Result<void> write_metadata(std::string_view name, const Texts& texts);
  /// Appends the attachment record of another file. `content` is its whole content.
  Result<void> write_attachment(std::span<const std::byte> content);
  /// Waits until everything that was written is on the disk.
  Result<void> sync() const;
  /// Writes the summary and closes the file. If the disk has no space for the summary, the rest of the file
  /// is kept.
  Result<void> close();

  const std::string& path() const { return path_; }
  std::uint64_t bytes() const { return offset_; }  ///< the size of the file, without the chunk that is open
  /// Return the number of messages in the file, of all channels or of one channel, without those in the
  /// open chunk.
  std::uint64_t messages() const { return messages_; }
  std::uint64_t messages(std::uint16_t channel) const {
    const auto found = of_channel_.find(channel);
    return found == of_channel_.end() ? 0 : found->second;
  }

 private:
  struct ChunkOfFile {
    std::uint64_t offset, length, first_ns, last_ns;
    std::map<std::uint16_t, std::uint64_t> indexes;
    std::uint64_t indexes_length, data_bytes, size;
  };
  /// Records that are written together to the file.
  struct Chunk {
    Bytes records{};
    bool defines = false;  ///< true: the chunk contains a schema or a channel
    std::uint64_t first_ns = UINT64_MAX, last_ns = 0;
    std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> messages{};
  };
  struct MetadataOfFile {
    std::uint64_t offset, length;
    std::string name;
  };
  struct AttachmentOfFile {
    std::uint64_t offset, length, log_ns, create_ns, data_bytes;
    std::string name, media_type;
  };

  McapWriter(int descriptor, std::string path, const Options& options);
  void add_head(const Message& message, Chunk& chunk);
  void add_definitions(std::uint16_t channel, Chunk& chunk);
  Result<void> write_chunk(Chunk& chunk, std::span<const std::byte> tail);
  Bytes chunk_head(const Chunk& chunk, std::uint64_t size, std::uint64_t written, std::uint32_t crc) const;
  void add_statistics(Bytes& to) const;
  void add_chunk_index(Bytes& to, const ChunkOfFile& chunk) const;
  Bytes summary() const;
  /// Appends all bytes, or none of them if there is an error.
  Result<void> append(std::span<const std::span<const std::byte>> parts);
  Result<void> fault(int code);

  int descriptor_;
  std::string path_;
  Options options_;
  std::uint64_t offset_ = 0;
  std::uint32_t crc_ = 0;  ///< the checksum of all bytes so far
  bool failed_ = false;
  std::uint64_t messages_ = 0;
  Chunk open_{};
  std::map<std::uint16_t, std::pair<Schema, bool>> schemas_{};    ///< true: the schema is in the file
  std::map<std::uint16_t, std::pair<Channel, bool>> channels_{};  ///< true: the channel is in the file
  std::map<std::uint16_t, std::uint64_t> of_channel_{};
  std::vector<ChunkOfFile> chunks_{};
  std::vector<MetadataOfFile> metadata_{};
  std::vector<AttachmentOfFile> attachments_{};
};

}  // namespace sft::recording
