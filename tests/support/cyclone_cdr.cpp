#include "tests/support/cyclone_cdr.h"

#include <dds/ddsi/ddsi_cdrstream.h>

#include <algorithm>
#include <stdexcept>

namespace sft::test {

std::vector<std::byte> cyclone_serialize(const dds_topic_descriptor_t& type, const void* c_struct) {
  return cyclone_serialize(type, c_struct, false, std::endian::little);
}

std::vector<std::byte> cyclone_serialize(const dds_topic_descriptor_t& type, const void* c_struct,
                                         bool is_xcdr2, std::endian byte_order) {
  dds_ostream_t stream;
  dds_ostream_init(&stream, 0, is_xcdr2 ? CDR_ENC_VERSION_2 : CDR_ENC_VERSION_1);
  const bool ok = dds_stream_write_with_byte_order(
                      &stream, static_cast<const char*>(c_struct), type.m_ops,
                      byte_order == std::endian::little ? DDSRT_BOSEL_LE : DDSRT_BOSEL_BE) != nullptr;
  const auto* first = reinterpret_cast<const std::byte*>(stream.m_buffer);
  std::vector<std::byte> bytes(first, first + stream.m_index);
  dds_ostream_fini(&stream);
  if (!ok) throw std::runtime_error("Cyclone does not serialize this sample");
  return bytes;
}

const void* CycloneReader::deserialize(std::span<const std::byte> body) {
  free_sample();
  const auto size = static_cast<std::uint32_t>(body.size());
  // Cyclone changes the bytes in place; the pointer must not be null even if there are no bytes.
  std::vector<std::byte> bytes(body.size() + 1);
  std::copy(body.begin(), body.end(), bytes.begin());
  std::uint32_t end = 0;
  auto* first = reinterpret_cast<char*>(bytes.data());
  if (dds_stream_normalize_data(first, &end, size, false, CDR_ENC_VERSION_1, type_->m_ops) == nullptr)
    return nullptr;
  if (end != size) return nullptr;

  dds_istream_t stream;
  dds_istream_init(&stream, size, first, CDR_ENC_VERSION_1);
  sample_ = dds_alloc(type_->m_size);  // is zeroed
  dds_stream_read(&stream, static_cast<char*>(sample_), type_->m_ops);
  dds_istream_fini(&stream);
  return sample_;
}

void CycloneReader::free_sample() {
  if (sample_ != nullptr) dds_sample_free(sample_, type_, DDS_FREE_ALL);
  sample_ = nullptr;
}

bool cyclone_writes_plain_cdr(const dds_topic_descriptor_t& type) {
  ddsi_sertype_extensibility extensibility{};
  return dds_stream_extensibility(type.m_ops, &extensibility) && extensibility == DDSI_SERTYPE_EXT_FINAL &&
         dds_stream_minimum_xcdr_version(type.m_ops) == CDR_ENC_VERSION_1;
}

}  // namespace sft::test
