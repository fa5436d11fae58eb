#include "tools/recording/mcap_writer.h"

#include <fcntl.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

namespace sft::recording {

namespace {

/// Appends a record whose content `fill` writes.
template <class Fill>
void add_record(Bytes& to, Opcode opcode, const Fill& fill) {
  ByteWriter writer(to);
  writer.number(static_cast<std::uint8_t>(opcode));
  const std::size_t begin = writer.begin_length<std::uint64_t>();
  fill(writer);
  writer.end_length<std::uint64_t>(begin);
}

void add_schema(Bytes& to, const Schema& schema) {
  add_record(to, Opcode::schema, [&](ByteWriter& writer) {
    writer.number(schema.id);
    writer.text(schema.name);
    writer.text(schema.encoding);
    writer.text(schema.data);
  });
}

void add_channel(Bytes& to, const Channel& channel) {
  add_record(to, Opcode::channel, [&](ByteWriter& writer) {
    writer.number(channel.id);
    writer.number(channel.schema);
    writer.text(channel.topic);
    writer.text(channel.encoding);
    writer.texts(channel.metadata);
  });
}

std::size_t write_some(int descriptor, std::span<const std::span<const std::byte>> parts, std::size_t skip) {
  std::array<iovec, 4> pieces{};
  int count = 0;
  for (const auto& part : parts) {
    const std::size_t skipped = std::min(skip, part.size());
    skip -= skipped;
    if (skipped == part.size()) continue;
    // writev() writes from the bytes and does not change them.
    pieces[static_cast<std::size_t>(count++)] = {const_cast<std::byte*>(part.data()) + skipped,
                                                 part.size() - skipped};
  }
  ssize_t written = 0;
  do written = writev(descriptor, pieces.data(), count);
  while (written < 0 && errno == EINTR);
  return written < 0 ? 0 : static_cast<std::size_t>(written);
}

}  // namespace

Result<McapWriter> McapWriter::create(const std::string& path, const Options& options) {
  constexpr mode_t mode = 0666;
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  if (descriptor < 0) {
    return fail(errno == EACCES ? Errc::no_permission : Errc::system,
                "'" + path + "' cannot be made: " + std::generic_category().message(errno));
  }
  McapWriter writer(descriptor, path, options);
  Bytes begin(bytes_of(magic).begin(), bytes_of(magic).end());
  add_record(begin, Opcode::header, [&](ByteWriter& to) {
    to.text("ros2");
    to.text(options.library);
  });
  const std::array<std::span<const std::byte>, 1> parts{begin};
  if (const Result<void> done = writer.append(parts); !done) return tl::unexpected(done.error());
  return writer;
}

McapWriter::McapWriter(int descriptor, std::string path, const Options& options)
    : descriptor_(descriptor), path_(std::move(path)), options_(options) {}

McapWriter::McapWriter(McapWriter&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      path_(std::move(other.path_)),
      options_(std::move(other.options_)),
      offset_(other.offset_),
      crc_(other.crc_),
      failed_(other.failed_),
      messages_(other.messages_),
      open_(std::move(other.open_)),
      schemas_(std::move(other.schemas_)),
      channels_(std::move(other.channels_)),
      of_channel_(std::move(other.of_channel_)),
      chunks_(std::move(other.chunks_)),
      metadata_(std::move(other.metadata_)),
      attachments_(std::move(other.attachments_)) {}

McapWriter::~McapWriter() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<void> McapWriter::fault(int code) {
  failed_ = true;
  return fail(Errc::system, "'" + path_ + "' cannot be written: " + std::generic_category().message(code));
}

Result<void> McapWriter::append(std::span<const std::span<const std::byte>> parts) {
  std::uint64_t size = 0;
  for (const auto& part : parts) size += part.size();
  for (std::size_t done = 0; done < size;) {
    errno = 0;
    const std::size_t written = write_some(descriptor_, parts, done);
    done += written;
    if (written > 0) continue;
    const int code = errno == 0 ? EIO : errno;
    // Removes the incomplete record, so that the file ends with the last complete record.
    if (ftruncate(descriptor_, static_cast<off_t>(offset_)) == 0)
      (void)lseek(descriptor_, static_cast<off_t>(offset_), SEEK_SET);
    return fault(code);
  }
  for (const auto& part : parts) crc_ = crc32(crc_, part);
  // The system starts to write now, so that nearly all data are on the disk if it is removed.
  (void)sync_file_range(descriptor_, static_cast<off_t>(offset_), static_cast<off_t>(size),
                        SYNC_FILE_RANGE_WRITE);
  offset_ += size;
  return {};
}

void McapWriter::add_definitions(std::uint16_t channel, Chunk& chunk) {
  auto& [known, is_written] = channels_[channel];
  if (std::exchange(is_written, true)) return;
  if (known.schema != 0) {
    auto& [schema, schema_written] = schemas_[known.schema];
    if (!std::exchange(schema_written, true)) add_schema(chunk.records, schema);
  }
  add_channel(chunk.records, known);
  chunk.defines = true;
}

/// Appends the head of a message record. The caller appends the data.
void McapWriter::add_head(const Message& message, Chunk& chunk) {
  add_definitions(message.channel, chunk);
  chunk.messages[message.channel].emplace_back(message.log_ns, chunk.records.size());
  chunk.first_ns = std::min(chunk.first_ns, message.log_ns);
  chunk.last_ns = std::max(chunk.last_ns, message.log_ns);
  ByteWriter writer(chunk.records);
  writer.number(static_cast<std::uint8_t>(Opcode::message));
  writer.number(static_cast<std::uint64_t>(message_head_bytes + message.data.size()));
  writer.number(message.channel);
  writer.number(message.sequence);
  writer.number(message.log_ns);
  writer.number(message.publish_ns);
}

Result<void> McapWriter::write(const Message& message) {
  if (failed_) return fault(EIO);
  const bool is_large = message.data.size() >= options_.large_bytes;
  if (is_large && open_.defines) {
    // The message may need these definitions, which must be before it in the file.
    if (const Result<void> done = flush(); !done) return done;
  }
  Chunk own;
  Chunk& chunk = is_large ? own : open_;
  add_head(message, chunk);
  if (is_large) return write_chunk(own, message.data);
  chunk.records.insert(chunk.records.end(), message.data.begin(), message.data.end());
  return open_.records.size() < options_.chunk_bytes ? Result<void>() : flush();
}

Result<void> McapWriter::flush() {
  if (open_.messages.empty()) return {};
  if (failed_) return fault(EIO);
  Result<void> done = write_chunk(open_, {});
  open_.records.clear();  // keeps its memory
  open_.messages.clear();
  open_.defines = false;
  open_.first_ns = UINT64_MAX;
  open_.last_ns = 0;
  return done;
}

Bytes McapWriter::chunk_head(const Chunk& chunk, std::uint64_t size, std::uint64_t written,
                             std::uint32_t crc) const {
  const std::string_view compression = name_of(options_.compression);
  Bytes head;
  ByteWriter writer(head);
  writer.number(static_cast<std::uint8_t>(Opcode::chunk));
  writer.number(static_cast<std::uint64_t>(8 + 8 + 8 + 4 + 4 + compression.size() + 8 + written));
  writer.number(chunk.first_ns);
  writer.number(chunk.last_ns);
  writer.number(size);
  writer.number(crc);
  writer.text(compression);
  writer.number(written);
  return head;
}

/// Writes the records of a chunk and their indexes. The last record continues in `tail`.
Result<void> McapWriter::write_chunk(Chunk& chunk, std::span<const std::byte> tail) {
  const std::uint64_t size = chunk.records.size() + tail.size();
  const std::uint32_t crc = crc32(crc32(0, chunk.records), tail);
  Bytes compressed;
  const bool is_plain = options_.compression == Compression::none;
  if (!is_plain) {
    chunk.records.insert(chunk.records.end(), tail.begin(), tail.end());
    if (const Result<void> done = compress(options_.compression, chunk.records, compressed); !done)
      return done;
  }
  const std::uint64_t data_bytes = is_plain ? size : compressed.size();
  const Bytes head = chunk_head(chunk, size, data_bytes, crc);
  ChunkOfFile made{.offset = offset_,
                   .length = head.size() + data_bytes,
                   .first_ns = chunk.first_ns,
                   .last_ns = chunk.last_ns,
                   .indexes = {},
                   .indexes_length = 0,
                   .data_bytes = data_bytes,
                   .size = size};
  Bytes indexes;
  for (const auto& [channel, messages] : chunk.messages) {
    made.indexes[channel] = made.offset + made.length + indexes.size();
    add_record(indexes, Opcode::message_index, [&](ByteWriter& writer) {
      writer.number(channel);
      writer.number(static_cast<std::uint32_t>(16 * messages.size()));
      for (const auto& [time, offset] : messages) {
        writer.number(time);
        writer.number(offset);
      }
    });
  }
  made.indexes_length = indexes.size();
  using Part = std::span<const std::byte>;
  const std::array<Part, 4> parts{head, is_plain ? Part(chunk.records) : Part(compressed),
                                  is_plain ? tail : Part(), indexes};
  if (const Result<void> done = append(parts); !done) return done;
  for (const auto& [channel, messages] : chunk.messages) {
    of_channel_[channel] += messages.size();
    messages_ += messages.size();
  }
  chunks_.push_back(std::move(made));
  return {};
}

Result<void> McapWriter::write_metadata(std::string_view name, const Texts& texts) {
  if (failed_) return fault(EIO);
  Bytes record;
  add_record(record, Opcode::metadata, [&](ByteWriter& writer) {
    writer.text(name);
    writer.texts(texts);
  });
  MetadataOfFile made{offset_, record.size(), std::string(name)};
  const std::array<std::span<const std::byte>, 1> parts{record};
  if (const Result<void> done = append(parts); !done) return done;
  metadata_.push_back(std::move(made));
  return {};
}

Result<void> McapWriter::write_attachment(std::span<const std::byte> content) {
  if (failed_) return fault(EIO);
  ByteReader from(content);
  AttachmentOfFile made;
  made.offset = offset_;
  made.length = record_head_bytes + content.size();
  made.log_ns = from.number<std::uint64_t>();
  made.create_ns = from.number<std::uint64_t>();
  made.name = from.text();
  made.media_type = from.text();
  made.data_bytes = from.number<std::uint64_t>();
  if (!from.is_good()) return fail(Errc::malformed, "an attachment ends early");
  Bytes head;
  ByteWriter writer(head);
  writer.number(static_cast<std::uint8_t>(Opcode::attachment));
  writer.number(static_cast<std::uint64_t>(content.size()));
  const std::array<std::span<const std::byte>, 2> parts{head, content};
  if (const Result<void> done = append(parts); !done) return done;
  attachments_.push_back(std::move(made));
  return {};
}

Result<void> McapWriter::sync() const {
  // The file is not on a disk
  if (fdatasync(descriptor_) == 0 || errno == EINVAL || errno == EROFS) return {};
  return fail(Errc::system, "'" + path_ + "' cannot be written: " + std::generic_category().message(errno));
}

void McapWriter::add_statistics(Bytes& to) const {
  std::uint64_t first = UINT64_MAX, last = 0;
  for (const ChunkOfFile& chunk : chunks_) {
    first = std::min(first, chunk.first_ns);
    last = std::max(last, chunk.last_ns);
  }
  const auto is_written = [](const auto& one) { return one.second.second; };
  add_record(to, Opcode::statistics, [&](ByteWriter& writer) {
    writer.number(messages_);
    writer.number(static_cast<std::uint16_t>(std::ranges::count_if(schemas_, is_written)));
    writer.number(static_cast<std::uint32_t>(std::ranges::count_if(channels_, is_written)));
    writer.number(static_cast<std::uint32_t>(attachments_.size()));
    writer.number(static_cast<std::uint32_t>(metadata_.size()));
    writer.number(static_cast<std::uint32_t>(chunks_.size()));
    writer.number(chunks_.empty() ? std::uint64_t{0} : first);
    writer.number(last);
    const std::size_t counts = writer.begin_length<std::uint32_t>();
    for (const auto& [channel, count] : of_channel_) {
      writer.number(channel);
      writer.number(count);
    }
    writer.end_length<std::uint32_t>(counts);
  });
}

void McapWriter::add_chunk_index(Bytes& to, const ChunkOfFile& chunk) const {
  add_record(to, Opcode::chunk_index, [&](ByteWriter& writer) {
    for (const std::uint64_t number : {chunk.first_ns, chunk.last_ns, chunk.offset, chunk.length})
      writer.number(number);
    const std::size_t indexes = writer.begin_length<std::uint32_t>();
    for (const auto& [channel, offset] : chunk.indexes) {
      writer.number(channel);
      writer.number(offset);
    }
    writer.end_length<std::uint32_t>(indexes);
    writer.number(chunk.indexes_length);
    writer.text(name_of(options_.compression));
    writer.number(chunk.data_bytes);
    writer.number(chunk.size);
  });
}

/// Returns the end of the file: everything after the last chunk.
Bytes McapWriter::summary() const {
  Bytes end;
  add_record(end, Opcode::data_end, [&](ByteWriter& writer) { writer.number(crc_); });
  const std::size_t begin = end.size();
  Bytes offsets;
  const auto group = [&](Opcode opcode, const auto& add) {
    const std::size_t group_begin = end.size();
    add();
    if (end.size() == group_begin) return;
    add_record(offsets, Opcode::summary_offset, [&](ByteWriter& writer) {
      writer.number(static_cast<std::uint8_t>(opcode));
      writer.number(static_cast<std::uint64_t>(offset_ + group_begin));
      writer.number(static_cast<std::uint64_t>(end.size() - group_begin));
    });
  };
  group(Opcode::schema, [&] {
    for (const auto& [id, known] : schemas_)
      if (known.second) add_schema(end, known.first);
  });
  group(Opcode::channel, [&] {
    for (const auto& [id, known] : channels_)
      if (known.second) add_channel(end, known.first);
  });
  group(Opcode::statistics, [&] { add_statistics(end); });
  group(Opcode::chunk_index, [&] {
    for (const ChunkOfFile& chunk : chunks_) add_chunk_index(end, chunk);
  });
  group(Opcode::attachment_index, [&] {
    for (const AttachmentOfFile& one : attachments_) {
      add_record(end, Opcode::attachment_index, [&](ByteWriter& writer) {
        for (const std::uint64_t number : {one.offset, one.length, one.log_ns, one.create_ns, one.data_bytes})
          writer.number(number);
        writer.text(one.name);
        writer.text(one.media_type);
      });
    }
  });
  group(Opcode::metadata_index, [&] {
    for (const MetadataOfFile& one : metadata_) {
      add_record(end, Opcode::metadata_index, [&](ByteWriter& writer) {
        writer.number(one.offset);
        writer.number(one.length);
        writer.text(one.name);
      });
    }
  });
  const std::uint64_t offsets_begin = offset_ + end.size();
  ByteWriter writer(end);
  writer.raw(offsets);
  writer.number(static_cast<std::uint8_t>(Opcode::footer));
  writer.number(std::uint64_t{20});
  writer.number(static_cast<std::uint64_t>(offset_ + begin));
  writer.number(offsets_begin);
  writer.number(crc32(0, std::span(end).subspan(begin)));
  writer.raw(bytes_of(magic));
  return end;
}

Result<void> McapWriter::close() {
  Result<void> done;
  if (!failed_) done = flush();
  const bool was_whole = done.has_value() && !failed_;
  // If an incomplete chunk was removed, there may be enough space for the summary.
  const Bytes end = summary();
  const std::array<std::span<const std::byte>, 1> parts{end};
  if (const Result<void> ended = append(parts); !ended && was_whole) done = ended;
  if (was_whole && done) done = sync();
  ::close(std::exchange(descriptor_, -1));
  return done;
}

}  // namespace sft::recording
