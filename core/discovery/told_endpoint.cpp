#include "core/discovery/told_endpoint.h"

#include <algorithm>
#include <utility>

#include "core/discovery/leases.h"

namespace sft::core {

using std::chrono::milliseconds;

milliseconds ToldEndpoint::lease() const {
  return endpoint_ == nullptr ? lease_default : std::min(endpoint_->life_lease, lease_max);
}

bool ToldEndpoint::is_ahead_of(const Claim& claim) const {
  return endpoint_ != nullptr && !is_untrue_ && endpoint_->announcer != claim.speaker.participant &&
         endpoint_->node_id == claim.endpoint->node_id && claim.endpoint->revision < endpoint_->revision;
}

void ToldEndpoint::believe(const Claim& claim, std::vector<LinkId> silent, Time now) {
  lost_at_.reset();
  if (is_truth_open(claim, now)) return;
  const bool is_told = !lost_ && !is_untrue_ && is_by(claim.endpoint->announcer) &&
                       endpoint_->revision == claim.endpoint->revision;
  if (is_told && silent == silent_) return;
  silent_ = std::move(silent);
  tell(claim);
}

/// Returns true while it is not known yet what is true. A link that is made anew tells of requests after
/// endpoints.
bool ToldEndpoint::is_truth_open(const Claim& claim, Time now) {
  constexpr milliseconds requests_come_within{500};
  if (!is_untrue_) return false;
  if (claim.untrue) return true;
  if (!true_from_) true_from_ = now + requests_come_within;
  const bool request_may_come =
      endpoint_ != nullptr && say_the_same(*endpoint_, *claim.endpoint) && asked() > claim.asked();
  return request_may_come && now < *true_from_;
}

/// Tells that the endpoint has departed, if what was told was not true: a lower number than the one that was
/// told would be taken for old.
void ToldEndpoint::take_back_if_untrue(const Claim& claim) {
  true_from_.reset();
  if (!std::exchange(is_untrue_, false) || endpoint_ == nullptr) return;
  if (say_the_same(*endpoint_, *claim.endpoint) && asked() <= claim.asked()) return;
  endpoint_.reset();
  request_.reset();
  news_.emplace_back(EndpointDeparted{claim.endpoint->id});
}

void ToldEndpoint::tell(const Claim& claim) {
  take_back_if_untrue(claim);
  const bool is_same_speaker = is_by(claim.endpoint->announcer);
  const bool is_same_node = endpoint_ != nullptr && endpoint_->node_id == claim.endpoint->node_id;
  if (!is_same_node) forget_request();  // another node's request is not this reader's
  // Nodes that the endpoint does not concern any more must not keep it.
  if (endpoint_ != nullptr &&
      (endpoint_->topic != claim.endpoint->topic || endpoint_->role != claim.endpoint->role))
    news_.emplace_back(EndpointDeparted{endpoint_->id});
  endpoint_ = claim.endpoint;
  lost_ = false;
  news_.emplace_back(EndpointSeen{endpoint_, silent_});
  const bool is_told = is_same_speaker && claim.request && claim.request->sequence <= asked();
  if (!claim.request || is_told || claim.request->sequence <= endpoint_->request.sequence) return;
  request_ = claim.request;
  news_.emplace_back(*request_);
}

void ToldEndpoint::request(const Request& request) {
  if (request.sequence <= asked()) return;
  request_ = request;
  news_.emplace_back(request);
}

void ToldEndpoint::repeat(std::vector<News>& news) const {
  if (endpoint_ == nullptr || lost_) return;
  news.emplace_back(EndpointSeen{endpoint_, silent_});
  if (asked() > endpoint_->request.sequence) news.emplace_back(*request_);
}

/// An endpoint that nobody keeps alive is lost at once if its node has been silent already. Else a link was
/// dropped or made anew, here or there: then the endpoint has its lease to return by another link.
void ToldEndpoint::lose(Time heard, Time now) {
  if (lost_ || endpoint_ == nullptr) return;
  if (!lost_at_) {
    const bool was_silent = now - heard > silence_in(lease());
    lost_at_ = was_silent ? now : heard + lease();
  }
  if (now < *lost_at_) return;
  lost_ = true;
  news_.emplace_back(EndpointLost{endpoint_->id});
}

}  // namespace sft::core
