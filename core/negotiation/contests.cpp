#include "core/negotiation/contests.h"

#include "core/negotiation/remote_requests.h"

namespace sft::core {

namespace {

/// Returns true if others may take, or have already taken, what was said in our reader's name for its
/// request.
bool outbids(const Request& said, const Request& ours) {
  Request copy = said;
  copy.announcer = ours.announcer;
  return said.sequence > ours.sequence || (said.sequence == ours.sequence && copy != ours);
}

}  // namespace

void Contests::announced(Endpoint& ours, const Endpoint& said) {
  Endpoint copy = said;
  copy.request = ours.request;
  copy.revision = ours.revision;
  copy.announcer = ours.announcer;
  const bool is_copy = copy == ours && said.revision == ours.revision;
  const bool is_old = said.revision < ours.revision;
  const bool asks_for_more = outbids(said.request, ours.request);
  if ((is_copy || is_old) && !asks_for_more) return;
  if (said.revision - ours.revision <= RemoteRequests::jump_max) ours.revision = said.revision;
  contest(ours, said.request, "is announced by somebody else, who calls the node '" + said.node + "'");
}

void Contests::withdrawn(Endpoint& ours) { contest(ours, {}, "was withdrawn by somebody else"); }

void Contests::requested(Endpoint& ours, const Request& said) {
  if (outbids(said, ours.request)) contest(ours, said, "is asked for something by somebody else");
}

/// The endpoint is to be announced anew, with a request that is later than everything that was said in its
/// name.
void Contests::contest(Endpoint& ours, const Request& said, std::string how) {
  Request& request = ours.request;
  if (ours.role == Role::reader) {
    const bool reachable =
        said.sequence > request.sequence && said.sequence - request.sequence <= RemoteRequests::jump_max;
    request.sequence = (reachable ? said.sequence : request.sequence) + 1;
  }
  contested_.push_back({ours.id, std::move(how)});
}

}  // namespace sft::core
