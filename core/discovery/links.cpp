#include "core/discovery/links.h"

#include <algorithm>

namespace sft::core {

namespace {

bool holds_text(const std::vector<std::string>& texts, const std::string& text) {
  return std::ranges::find(texts, text) != texts.end();
}

}  // namespace

Links::~Links() {
  for (const OpenLink& one : links_)
    one.link->flush(settings_.timing.farewell_max / static_cast<int>(links_.size()));
}

Result<void> Links::use(const std::vector<LinkSpec>& wanted, const KnownHosts& hosts) {
  Result<void> result;
  hosts_ = hosts;
  failures_.clear();
  for (const LinkSpec& spec : wanted) {
    OpenLink* const before = present(spec);
    if (before != nullptr && before->config == settings_.config.text_for(spec, hosts_)) continue;
    const Result<void> opened = open(spec, before);
    if (opened) continue;
    failures_.push_back(spec.interface + ": " + opened.error().message);
    if (result) result = opened;
  }
  for (OpenLink& one : links_) {
    const bool is_wanted = std::ranges::find(wanted, one.spec) != wanted.end();
    if (is_wanted || one.is_retired) continue;
    one.is_retired = true;
    known_.with(
        [&](Peers& peers, Directory&) { peers.link_retired(one.id, std::chrono::steady_clock::now()); });
  }
  return result;
}

/// The new link is opened before the old link is retired, so that the process always has a participant.
Result<void> Links::open(const LinkSpec& spec, OpenLink* instead_of) {
  OpenLink link{
      .id = ++links_made_, .spec = spec, .config = settings_.config.text_for(spec, hosts_), .link = {}};
  if (const Result<void> opened = open_link(link); !opened) {
    link.link.reset();
    known_.link_closed(link.id);
    return opened;
  }
  if (instead_of != nullptr) {
    instead_of->is_retired = true;
    known_.with([&](Peers& peers, Directory&) {
      peers.link_replaced(instead_of->id, link.id, std::chrono::steady_clock::now());
    });
  }
  links_.push_back(std::move(link));
  return {};
}

Result<std::shared_ptr<const CycloneDomain>> Links::open_domain(const OpenLink& link) {
  std::vector<std::string> complaints;
  auto domain = cyclone_domain(
      {.config = link.config, .is_secured = settings_.config.is_secured, .threads = settings_.threads},
      complaints);
  for (std::string& complaint : complaints) {
    if (!holds_text(settings_.config.warnings, complaint) && !holds_text(warnings_, complaint))
      warnings_.push_back(std::move(complaint));
  }
  return domain;
}

Result<void> Links::open_link(OpenLink& link) {
  auto domain = open_domain(link);
  if (!domain) return tl::unexpected(domain.error());
  const std::optional<std::uint16_t> port = settings_.config.heartbeat_port_on(link.spec);
  known_.link_made(link.id, link.spec, port.has_value());
  auto opened = ControlLink::open({.link = link.id,
                                   .domain = std::move(*domain),
                                   .process = own_.process(),
                                   .is_secured = settings_.config.is_secured,
                                   .spec = link.spec,
                                   .heartbeat_port = port},
                                  known_);
  if (!opened) return tl::unexpected(opened.error());
  link.link = std::move(*opened);
  if (Result<void> used = link.link->follow(use_); !used) return used;
  for (const Role role : both_roles) {
    for (const auto& [key, record] : own_.records(role).all()) link.link->write(role, {key, record});
  }
  link.link->give_heartbeat(own_.digests());
  return {};
}

Links::OpenLink* Links::present(const LinkSpec& spec) {
  const auto link =
      std::ranges::find_if(links_, [&](const OpenLink& one) { return !one.is_retired && one.spec == spec; });
  return link == links_.end() ? nullptr : &*link;
}

Result<LinkSpec> Links::renew(LinkId id) {
  const auto link = std::ranges::find(links_, id, &OpenLink::id);
  const LinkSpec spec = link->spec;
  return open(spec, &*link).map([&] { return spec; }).map_error([&](const Error& error) {
    return Error{error.code, "the link on " + spec.interface + " cannot be made anew: " + error.message};
  });
}

void Links::close(LinkId id) {
  if (std::erase_if(links_, [&](const OpenLink& one) { return one.id == id; }) > 0) known_.link_closed(id);
}

void Links::close_all() {
  for (const OpenLink& one : std::exchange(links_, {})) known_.link_closed(one.id);
}

Result<void> Links::follow(const LinkUse& use) {
  use_ = use;
  Result<void> result;
  for (const OpenLink& one : links_) {
    if (Result<void> used = one.link->follow(use); !used) result = std::move(used);
  }
  return result;
}

Result<void> Links::write_again() {
  Result<void> result;
  for (const OpenLink& one : links_) {
    if (Result<void> written = one.link->write_again(); !written) result = std::move(written);
  }
  return result;
}

std::vector<LinkSpec> Links::specs() const {
  std::vector<LinkSpec> specs;
  for (const OpenLink& one : links_) {
    if (!one.is_retired) specs.push_back(one.spec);
  }
  std::ranges::sort(specs);
  return specs;
}

ControlLink* Links::find(LinkId id) const {
  const auto link = std::ranges::find(links_, id, &OpenLink::id);
  return link == links_.end() ? nullptr : link->link.get();
}

}  // namespace sft::core
