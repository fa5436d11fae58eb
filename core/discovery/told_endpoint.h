// Remembers what was told of one endpoint, and decides what has to be told next: that the endpoint was seen,
// what its request is, that it is lost. Pure: claims and times go in, news come out.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/discovery/claim.h"
#include "core/discovery/discovery_news.h"
#include "core/platform/clock.h"

namespace sft::core {

class ToldEndpoint {
 public:
  /// `news` outlives this object.
  explicit ToldEndpoint(std::vector<News>& news) : news_(news) {}

  /// Null while nothing was told.
  const Endpoint* endpoint() const { return endpoint_.get(); }
  std::chrono::milliseconds lease() const;
  bool is_by(AnnouncerId participant) const {
    return endpoint_ != nullptr && endpoint_->announcer == participant;
  }
  /// True if that claim is older than what was told of the same node, by another participant.
  bool is_ahead_of(const Claim& claim) const;

  /// The claim is believed, and on those links its node is silent: tells that, if it is news.
  void believe(const Claim& claim, std::vector<LinkId> silent, Time now);
  /// A request that is believed: tells it, if it is news.
  void request(const Request& request);
  /// Another participant speaks for the endpoint: any request of it is news.
  void forget_request() { request_.reset(); }
  /// Nobody keeps the endpoint alive; somebody who did was heard last at `heard`. Tells that it is lost, once
  /// it is.
  void lose(Time heard, Time now);
  /// Adds to the news what was told and still holds.
  void repeat(std::vector<News>& news) const;
  bool is_lost() const { return lost_; }
  bool is_lost_before(Time before) const { return lost_ && *lost_at_ <= before; }

  /// Notes that the announcement may be somebody else's word.
  void doubt() { is_untrue_ = true; }
  bool is_in_doubt() const { return is_untrue_; }
  /// While that is in doubt, a link that is made anew is believed from then on.
  void doubt_until(Time time) { true_from_ = time; }

 private:
  std::uint64_t asked() const { return request_ ? request_->sequence : 0; }
  bool is_truth_open(const Claim& claim, Time now);
  void take_back_if_untrue(const Claim& claim);
  void tell(const Claim& claim);

  std::vector<News>& news_;
  std::shared_ptr<const Endpoint> endpoint_;
  std::vector<LinkId> silent_;        ///< told with endpoint_
  std::optional<Request> request_{};  ///< told last, apart from endpoint_
  std::optional<Time> lost_at_{};     ///< when the endpoint is lost, if nobody keeps it alive until then
  bool lost_ = false;                 ///< its loss was told
  bool is_untrue_ = false;            ///< may be somebody else's word
  std::optional<Time> true_from_{};   ///< when a link that is made anew is believed in any case
};

}  // namespace sft::core
