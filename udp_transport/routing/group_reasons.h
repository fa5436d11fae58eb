// The information for programs about each reader: its multicast group and the costs of that group, or the
// reason why the reader is in no group. The agent's thread writes it, and any thread may read it.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/seam/transport.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
#include "udp_transport/multicast/body_sizes.h"
#include "udp_transport/multicast/multicast_group.h"

namespace sft::udp {

class GroupReasons {
 public:
  struct Reader {
    const Destination* to = nullptr;
    std::string refusal{};  ///< the reason why the destination cannot be in a group; empty if it can
    Selection asked{};      ///< the reader's request
    /// The size of the parts of fields in `asked`; null if `asked` has no parts, or no part was measured.
    std::shared_ptr<const PartSize> part{};
    bool shares = false;  ///< true if the readers at the destination share one copy while it is in no group
    bool has_company = false;  ///< true if another destination could share a group with this one
  };
  using Readers = std::map<core::EndpointId, Reader>;
  using Groups = std::vector<std::shared_ptr<MulticastGroup>>;

  /// `sizes` may be null.
  void set_readers(Readers readers, std::shared_ptr<BodySizes> sizes);
  void set_groups(Groups groups);

  /// Returns the text about the reader; empty if no such reader is served. Any thread may call this.
  std::string of(core::EndpointId reader) const;

 private:
  /// Returns a text with the number of unrequested bytes that this reader would get if it shared one copy
  /// with all readers for whose destination `is_there` returns true.
  template <class IsThere>
  std::string unwanted(const Reader& reader, const IsThere& is_there) const SFT_REQUIRES(mutex_);
  std::string alone(const Reader& reader) const SFT_REQUIRES(mutex_);

  mutable core::Mutex mutex_ SFT_ACQUIRED_AFTER(core::lock_order::queues)
      SFT_ACQUIRED_BEFORE(core::lock_order::facts);
  Readers readers_ SFT_GUARDED_BY(mutex_);
  Groups groups_ SFT_GUARDED_BY(mutex_);
  std::shared_ptr<BodySizes> sizes_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::udp
