// Passes the connections between readers and writers to the receiving thread, as published immutable values
// (core::Published). A thread that removes a reader waits until the receiving thread does not use any former
// value. The receiving thread uses no value while listeners run.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/seam/transport.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
#include "core/sync/published.h"
#include "udp_transport/receive/inbox.h"
#include "udp_transport/receive/incoming_writer.h"

namespace sft::udp {

struct Subscriber {
  core::EndpointId reader = 0;
  std::shared_ptr<Inbox> inbox;
  std::shared_ptr<const std::vector<core::Accepted>> accepted;  ///< the reader's requests; the latest is last
  bool reliable = false;

  /// Returns true if the sample is for this reader. Requests before `first_request` have ended and do not
  /// count.
  bool accepts(const core::SampleBuffer& sample, std::uint64_t first_request = 0) const;
  /// Returns the number of the latest request of this reader that the writer has received.
  std::uint64_t heard_request() const;
};

/// The requests of all readers of a transport, by writer.
struct Subscriptions {
  std::vector<Stream> streams;
  std::vector<std::vector<Subscriber>> subscribers;  ///< one vector for each stream
};

class SubscriptionDirectory {
 public:
  SubscriptionDirectory() { subscriptions_.replace(std::make_shared<Subscriptions>()); }

  // Any thread may call the following functions.
  void add(core::EndpointId reader, const std::shared_ptr<Inbox>& inbox, const TypeSupport& type);
  Result<void> connect(const Inbox& reader, const core::Source& source);
  void announced(const Inbox& reader, const core::Source& source);
  void disconnect(const Inbox& reader, core::EndpointId writer);
  void accept(const Inbox& reader, std::vector<core::Accepted> accepted);
  /// Removes the reader. When this function returns, the reader's type is not used any more. Must not be
  /// called between enter() and leave().
  void remove(const Inbox& reader);

  // The following functions are for the receiving thread.

  /// Returns the latest subscriptions. Their types may be used until leave().
  const std::shared_ptr<const Subscriptions>& enter() {
    reading_.emplace(subscriptions_);
    subscriptions_.load();
    return subscriptions_.loaded();
  }
  void leave() { reading_.reset(); }

 private:
  struct Reader {
    core::EndpointId id;
    std::shared_ptr<Inbox> inbox;
    const TypeSupport* type;
    std::shared_ptr<const std::vector<core::Accepted>> accepted;
    std::vector<core::Source> sources;
  };
  Reader& find(const Inbox& reader) SFT_REQUIRES(mutex_);
  Result<void> check(const Reader& reader, const core::Source& source) const SFT_REQUIRES(mutex_);
  void publish() SFT_REQUIRES(mutex_);

  core::Mutex mutex_ SFT_ACQUIRED_AFTER(core::lock_order::endpoint)
      SFT_ACQUIRED_BEFORE(core::lock_order::queues);
  std::vector<Reader> readers_ SFT_GUARDED_BY(mutex_);
  core::Published<Subscriptions> subscriptions_;

  // The following members are used by the receiving thread.
  std::optional<core::Published<Subscriptions>::Reading> reading_;
};

}  // namespace sft::udp
