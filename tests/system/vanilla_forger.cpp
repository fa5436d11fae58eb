// A DDS node that writes any bytes as samples of a type, valid or forged. It reads records from its
// standard input: { uint32 bytes; } and this number of bytes, which begin with the encapsulation. It writes
// the number of matching readers to its standard output whenever that changes.
//
//   vanilla_forger DOMAIN TOPIC TYPE
#include <dds/dds.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>

#include "core/seam/buffer_pool.h"
#include "core/vanilla/raw_sample.h"

namespace {

using namespace sft::core;

bool read_all(void* to, std::size_t bytes) {
  for (std::size_t done = 0; done < bytes;) {
    const ssize_t n = read(STDIN_FILENO, static_cast<char*>(to) + done, bytes - done);
    if (n <= 0) return false;
    done += static_cast<std::size_t>(n);
  }
  return true;
}

/// The bytes lie where the encapsulation and the body of a sample lie, of a type without an index.
SampleHandle sample_of(std::uint32_t bytes, BufferPool& pool) {
  const std::size_t body_offset = sft::detail::SampleLayout(0).body_offset;
  SampleHandle sample = pool.take(body_offset + bytes);
  if (!sample || !read_all(sample->data + body_offset - sft::detail::encapsulation_bytes, bytes)) return {};
  sample->header().body_bytes = bytes - static_cast<std::uint32_t>(sft::detail::encapsulation_bytes);
  sample->source_stamp_ns = dds_time();
  return sample;
}

void report_matched(dds_entity_t, dds_publication_matched_status_t status, void*) {
  const std::uint32_t readers = status.current_count;
  if (write(STDOUT_FILENO, &readers, sizeof readers) != sizeof readers) std::_Exit(0);  // the test has ended
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const auto domain = static_cast<dds_domainid_t>(std::atoi(argv[1]));
  const dds_entity_t participant = dds_create_participant(domain, nullptr, nullptr);
  const RawTopic topic = raw_topic(participant, argv[2], argv[3]);
  dds_qos_t* const qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(10));
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
  dds_listener_t* const listener = dds_create_listener(nullptr);
  dds_lset_publication_matched(listener, report_matched);
  const dds_entity_t writer = dds_create_writer(participant, topic.entity, qos, listener);
  if (writer < 0) return 3;
  const std::shared_ptr<BufferPool> pool = BufferPool::make(64 << 20);
  std::uint32_t bytes = 0;
  while (read_all(&bytes, sizeof bytes)) {
    const SampleHandle sample = sample_of(bytes, *pool);
    if (!sample || dds_forwardcdr(writer, raw_sample(topic.type, sample, 0)) != DDS_RETCODE_OK) return 4;
  }
  dds_wait_for_acks(writer, DDS_SECS(10));
  dds_delete(participant);
}
