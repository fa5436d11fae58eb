// Tells the receiving thread who reads what. The receiving thread looks at an immutable snapshot. A thread
// that removes a reader waits until no older snapshot is in use, and none is in use while listeners run.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <vector>

#include "core/seam/transport.h"
#include "udp_transport/receive/inbox.h"
#include "udp_transport/receive/incoming_writer.h"

namespace sft::udp {

struct Subscriber {
  core::EndpointId reader = 0;
  std::shared_ptr<Inbox> inbox;
  std::vector<core::Accepted> accepted;  ///< the latest is the last
  bool reliable = false;

  /// Requests before `first_request` are over.
  bool accepts(const core::SampleBuffer& sample, std::uint64_t first_request = 0) const;
  /// The last request that the writer knows of.
  std::uint64_t heard_request() const;
};

/// The wishes of all readers of a transport, by writer.
struct Subscriptions {
  std::vector<Stream> streams;
  std::vector<std::vector<Subscriber>> subscribers;  ///< for each stream
};

class SubscriptionDirectory {
 public:
  SubscriptionDirectory() : latest_(std::make_shared<Subscriptions>()), followed_(latest_) {}

  // Any thread.
  void add(core::EndpointId reader, const std::shared_ptr<Inbox>& inbox, const TypeSupport& type);
  Result<void> connect(const Inbox& reader, const core::Source& source);
  void announced(const Inbox& reader, const core::Source& source);
  void disconnect(const Inbox& reader, core::EndpointId writer);
  void accept(const Inbox& reader, std::vector<core::Accepted> accepted);
  /// When it returns, the reader's type is not used any more.
  void remove(const Inbox& reader);

  // The receiving thread.

  /// The latest snapshot; its types may be used until leave().
  std::shared_ptr<const Subscriptions> enter();
  void leave();

 private:
  struct Reader {
    core::EndpointId id;
    std::shared_ptr<Inbox> inbox;
    const TypeSupport* type;
    std::vector<core::Accepted> accepted;
    std::vector<core::Source> sources;
  };
  Reader& find(const Inbox& reader);
  Result<void> check(const Reader& reader, const core::Source& source) const;
  void publish();

  std::mutex mutex_;
  std::condition_variable left_;
  std::vector<Reader> readers_;
  std::shared_ptr<const Subscriptions> latest_;
  std::shared_ptr<const Subscriptions> followed_;  ///< what the receiving thread got last
  bool entered_ = false;
  std::size_t waiting_ = 0;
};

}  // namespace sft::udp
