// Chunks that a writer was just delivering when it was killed: the references that its calls held are
// counted, but nobody has them any more, so the chunk would never be free again.
//
// A writer names such a chunk in its port's history for the time of delivery (writer_port.h), while it also
// holds it, so that the name is good as long as the ports of the dead have not been destroyed. Then the chunk
// is taken note of; once no reader of that writer is left, all references but the note itself are lost ones.
#pragma once

#include <cstdint>
#include <vector>

#include "shm_transport/iceoryx.h"

namespace iox::roudi {
class PortPool;
}

namespace sft::shm {

/// Used by one thread at a time, which keeps ports from being created or destroyed meanwhile.
class ChunkReclaimer {
 public:
  explicit ChunkReclaimer(iox::roudi::PortPool& ports) : ports_(ports) {}

  /// Before the ports of a dead process are destroyed: takes the names out of them.
  void note_deliveries(const iox::RuntimeName_t& dead);
  /// Frees what can be freed by now; returns how many chunks would have been lost.
  std::size_t reclaim();

 private:
  struct Suspect {
    iox::mepoo::ShmSafeUnmanagedChunk chunk;  ///< one counted reference
    iox::capro::ServiceDescription service;
  };
  bool has_readers(const iox::capro::ServiceDescription& service) const;

  iox::roudi::PortPool& ports_;
  std::vector<Suspect> suspects_;
};

}  // namespace sft::shm
