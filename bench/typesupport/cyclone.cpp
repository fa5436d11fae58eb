#include "bench/typesupport/cyclone.h"

#include <cstdint>

namespace sft::bench {

CycloneMessage::CycloneMessage(const dds_topic_descriptor_t& type)
    : type_(type), sample_(dds_alloc(type.m_size)) {  // filled with zeros
  dds_ostreamLE_init(&stream_, 0, CDR_ENC_VERSION_1);
}

CycloneMessage::~CycloneMessage() {
  dds_ostreamLE_fini(&stream_);
  dds_sample_free(sample_, &type_, DDS_FREE_ALL);
}

bool CycloneMessage::read(std::span<std::byte> body) {
  auto* bytes = reinterpret_cast<char*>(body.data());
  const auto size = static_cast<std::uint32_t>(body.size());
  std::uint32_t end = 0;
  if (dds_stream_normalize_data(bytes, &end, size, false, CDR_ENC_VERSION_1, type_.m_ops) == nullptr)
    return false;
  dds_istream_t stream;
  dds_istream_init(&stream, size, bytes, CDR_ENC_VERSION_1);
  dds_stream_read(&stream, static_cast<char*>(sample_), type_.m_ops);
  dds_istream_fini(&stream);
  return true;
}

std::size_t CycloneMessage::write() {
  stream_.x.m_index = 0;
  dds_stream_writeLE(&stream_, static_cast<const char*>(sample_), type_.m_ops);
  return stream_.x.m_index;
}

}  // namespace sft::bench
