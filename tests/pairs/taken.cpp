#include "tests/pairs/taken.h"

namespace sft::test {

void Taken::note(const SampleInfo& info, const FieldMask& mask, bool right) {
  const std::scoped_lock lock(mutex_);
  OfWriter& writer = writers_[info.writer];
  if (writer.received == 0) writer.first = info.sequence;
  writer.disordered += info.sequence <= writer.last ? 1 : 0;
  writer.last = info.sequence;
  ++writer.received;
  writer.by_shm += info.transport == TransportKind::shm ? 1 : 0;
  writer.wrong += right ? 0 : 1;
  writer.last_mask = to_string<PointCloud2>(mask);
  ++writer.masks[writer.last_mask];
}

nlohmann::json Taken::to_json() const {
  const std::scoped_lock lock(mutex_);
  nlohmann::json all = nlohmann::json::array();
  for (const auto& [id, w] : writers_) {
    all.push_back({{"writer", id},
                   {"first", w.first},
                   {"last", w.last},
                   {"received", w.received},
                   {"by_shm", w.by_shm},
                   {"wrong", w.wrong},
                   {"disordered", w.disordered},
                   {"masks", w.masks},
                   {"last_mask", w.last_mask}});
  }
  return all;
}

}  // namespace sft::test
