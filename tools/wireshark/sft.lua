-- SFT in Wireshark: dissectors for its datagrams (udp_transport/wire/wire_format.md), for the announcements and
-- requests of publishers and subscribers (core/control/sft_control.idl), and for heartbeats.
--
-- Copy this file into the folder "Personal Lua Plugins" (Help, About Wireshark, Folders), or try it with `tshark -X
-- lua_script:sft.lua -r capture.pcap`. The dissector recognises datagrams by their contents, on any port. With "Decode
-- As...", Wireshark treats all datagrams of a port as SFT, and reports faults in those that are not SFT.
--
-- Cyclone DDS sends control samples. Wireshark's own dissector of RTPS takes them out of the datagrams, and passes them
-- to the dissector here. Wireshark shows requests that did not fit into one datagram if the preference "Enable RTPS
-- Reassembly" (rtps.enable_rtps_reassembly) is on.
--
-- A new kind of datagram needs an entry in `kinds`, and a new flag an entry in `flags`. A new kind of record needs an
-- entry in `bodies`. A new version of the control topics needs its new members here, and a new `control_version`.
--
-- Larger than usual: users copy one file, and datagrams are explained by the requests in the same capture.

local sft = Proto("sft", "Selective Field Transmission")

local wire_version = 2
local common_bytes = 13

-- Facts from the control samples and datagrams of the capture. `names` has the requests of subscribers, by the number
-- that stands for a request in datagrams, and by topic and that number. `topics` has the topics of publishers and
-- subscribers by their ids, and `writers` the topics of publishers by their short ids. `types` has the types of
-- publishers and subscribers by their ids, and `leaves` the number of leaves of a publisher's type, by its short id.
-- The value is `false` if several publishers have the same short id and different topics or types. `heard` has the
-- short ids of publishers that sent datagrams with enough in their headers to recognize them.
local known = { names = {}, types = {}, leaves = {}, topics = {}, writers = {}, heard = {} }

function sft.init()
  known.names, known.types, known.leaves, known.topics, known.writers, known.heard = {}, {}, {}, {}, {}, {}
end

local f = {
  version = ProtoField.uint8("sft.version", "Version", base.DEC, nil, 0xf0),
  kind = ProtoField.uint8("sft.kind", "Kind", base.DEC, nil, 0x0f),
  flags = ProtoField.uint8("sft.flags", "Flags", base.HEX),
  variant = ProtoField.uint16("sft.variant", "Variant"),
  writer = ProtoField.uint32("sft.writer", "Writer", base.HEX),
  sequence = ProtoField.uint32("sft.sequence", "Sequence (low half)"),
  total = ProtoField.uint32("sft.total", "Bytes of the body"),
  mask = ProtoField.uint64("sft.mask", "Mask", base.HEX),
  meaning = ProtoField.string("sft.mask.meaning", "Meaning"),
  leaves = ProtoField.string("sft.leaves", "Leaves"),
  selection = ProtoField.string("sft.selection", "Asked for"),
  asked_in = ProtoField.framenum("sft.asked_in", "Asked for in frame", base.NONE, frametype.REQUEST),
  stamp = ProtoField.absolute_time("sft.stamp", "Published", base.UTC),
  offset = ProtoField.uint32("sft.offset", "Offset in the body"),
  rate_period = ProtoField.uint32("sft.rate.period_us", "Gate: period (us)"),
  rate_ordinal = ProtoField.uint32("sft.rate.ordinal", "Gate: ordinal"),
  history_reader = ProtoField.uint64("sft.history.reader", "Late reader", base.HEX),
  history_oldest = ProtoField.uint64("sft.history.oldest", "Oldest sequence sent to the late reader"),
  channel = ProtoField.uint32("sft.channel", "Channel"),
  sequence_high = ProtoField.uint32("sft.sequence_high", "Sequence (high half)"),
  ordinal = ProtoField.uint64("sft.ordinal", "Ordinal"),
  group = ProtoField.uint32("sft.group", "Multicast group"),
  group_ordinal = ProtoField.uint64("sft.group.ordinal", "Ordinal in the group"),
  member = ProtoField.uint32("sft.group.member", "Member"),
  group_port = ProtoField.uint16("sft.group.port", "Port for reports"),
  group_address = ProtoField.ipv4("sft.group.address", "Address of the group"),
  ahead = ProtoField.int64("sft.group.ahead", "Lead of the channel's ordinals"),
  heard = ProtoField.uint64("sft.group.heard", "Last ordinal received"),
  mask_word = ProtoField.uint64("sft.mask_word", "Mask word", base.HEX),
  payload = ProtoField.bytes("sft.payload", "Payload"),
  port = ProtoField.uint16("sft.heartbeat.port", "Port for acks"),
  first = ProtoField.uint64("sft.heartbeat.first", "First ordinal that can be sent again"),
  end_ = ProtoField.uint64("sft.heartbeat.end", "End of the ordinals sent"),
  waiting = ProtoField.uint32("sft.heartbeat.waiting", "Samples that wait behind the end"),
  reserved = ProtoField.uint32("sft.reserved", "Reserved"),
  reserved_short = ProtoField.uint16("sft.reserved_short", "Reserved"),
  parts = ProtoField.uint16("sft.ack.parts", "Missing parts"),
  flow = ProtoField.uint32("sft.flow", "Flow"),
  position = ProtoField.uint64("sft.flow.position", "Position (bytes sent before)"),
  window = ProtoField.uint32("sft.report.window", "Window (bytes in flight)"),
  datagrams = ProtoField.uint32("sft.flow.datagrams", "Datagrams sent before"),
  came = ProtoField.uint32("sft.report.came", "Datagrams received"),
  longest = ProtoField.uint32("sft.report.longest", "Longest datagram of late (bytes)"),
  sent_at = ProtoField.uint64("sft.flow.sent_at", "Sent at (hidden by a secret of the sender)"),
  next = ProtoField.uint64("sft.ack.next", "Next (all ordinals before it were received)"),
  missing = ProtoField.none("sft.missing", "Missing"),
  missing_ordinal = ProtoField.uint32("sft.missing.ordinal", "Ordinal (low half)"),
  missing_begin = ProtoField.uint32("sft.missing.begin", "From"),
  missing_end = ProtoField.uint32("sft.missing.end", "To"),
  samples = ProtoField.uint16("sft.packed.samples", "Samples"),
  bytes_each = ProtoField.uint16("sft.packed.bytes_each", "Bytes each (0: lengths follow)"),
  sample = ProtoField.none("sft.sample", "Sample"),
  length = ProtoField.uint16("sft.sample.bytes", "Bytes"),
  padding = ProtoField.bytes("sft.padding", "Padding"),
}

-- The flags: the bit of each, its name, and its meaning.
local flags = {
  { bit = 0x01, name = "mask_words", text = "The mask is a hash; its words follow" },
  { bit = 0x02, name = "rate", text = "A rate follows" },
  { bit = 0x04, name = "history", text = "A history mark follows" },
  { bit = 0x08, name = "channel", text = "A position in a channel follows" },
  { bit = 0x10, name = "lengths", text = "Each sample has its own length" },
  { bit = 0x20, name = "narrow_mask", text = "The mask has two bytes" },
  { bit = 0x40, name = "group", text = "A position in a multicast group follows" },
  { bit = 0x80, name = "merged", text = "The mask is the union of several masks" },
}
for _, flag in ipairs(flags) do
  flag.field = ProtoField.bool("sft.flags." .. flag.name, flag.text, 8, nil, flag.bit)
  f["flag_" .. flag.name] = flag.field
end
sft.fields = f

local malformed = ProtoExpert.new("sft.malformed", "Malformed", expert.group.MALFORMED, expert.severity.ERROR)
local loss = ProtoExpert.new("sft.loss", "Data is missing", expert.group.SEQUENCE, expert.severity.NOTE)
sft.experts = { malformed, loss }

local function has(set, bit) return set % (2 * bit) >= bit end

-- Adds the bits of a word of a mask to a set of leaves. `first` is the number of the word's lowest bit.
local function add_leaves(set, word, first)
  local halves = { word:lower(), word:higher() }
  for leaf = 0, 63 do
    if has(halves[leaf < 32 and 1 or 2], 2 ^ (leaf % 32)) then set[first + leaf] = true end
  end
end

-- Returns the leaves of a set from `first` on and before `last`, as runs: pairs of the first and the last leaf.
local function runs_of(set, first, last)
  local runs, begin = {}, nil
  for leaf = first, last do
    local is_in = leaf < last and set[leaf]
    if is_in and begin == nil then begin = leaf end
    if not is_in and begin ~= nil then
      runs[#runs + 1] = { begin, leaf - 1 }
      begin = nil
    end
  end
  return runs
end

-- Returns these runs as text: "0-3, 7".
local function runs_text(set, first, last)
  local texts = {}
  for i, run in ipairs(runs_of(set, first, last)) do
    texts[i] = run[1] == run[2] and string.format("%d", run[1]) or string.format("%d-%d", run[1], run[2])
  end
  return #texts == 0 and "none" or table.concat(texts, ", ")
end

-- Returns the bits of a word of the mask as text. `first` is the number of the word's lowest bit.
local function leaves_text(word, first)
  local set = {}
  add_leaves(set, word, first)
  return runs_text(set, first, first + 64)
end

-- A position in a datagram or a control sample, which advances with each read. A read beyond the end returns nil, and
-- the first failure is reported.
local Cursor = {}
Cursor.__index = Cursor

function Cursor.new(buffer, tree, expert_info)
  return setmetatable({ buffer = buffer, at = 0, tree = tree, expert_info = expert_info or malformed }, Cursor)
end
function Cursor:left() return self.buffer:len() - self.at end
function Cursor:fail(what)
  if not self.failed then self.tree:add_proto_expert_info(self.expert_info, what) end
  self.failed = true
end
function Cursor:take(bytes)
  if self.failed then return nil end
  if bytes > self:left() then
    self:fail((bytes - self:left()) .. " bytes are missing at the end")
    return nil
  end
  local range = self.buffer(self.at, bytes)
  self.at = self.at + bytes
  return range
end
-- Reads a number into a field. Returns the number and its item in the tree.
function Cursor:number(field, bytes)
  local range = self:take(bytes)
  if range == nil then return nil end
  local item = self.tree:add_le(field, range)
  return bytes == 8 and range:le_uint64() or range:le_uint(), item
end
function Cursor:stamp(field)
  local range = self:take(8)
  if range == nil then return end
  local ns = range:le_int64()
  local second = Int64(1000000000)
  self.tree:add(field, range, NSTime((ns / second):tonumber(), (ns % second):tonumber()))
end
function Cursor:rest(field)
  if self.failed or self:left() == 0 then return end
  self.tree:add(field, self:take(self:left()))
end

-- Reads the mark of a sample that is sent to a group. The only other mark may be a rate, since a group has no late
-- readers, and each member knows the sample's position in its channel.
local function read_group_mark(c, set)
  if has(set, 0x04) or has(set, 0x08) then c:fail("Only a rate may stand beside a position in a group") end
  local group = c:number(f.group, 4)
  c:number(f.sequence_high, 4)
  local ordinal = c:number(f.group_ordinal, 8)
  if ordinal == UInt64(0) then c:fail("Ordinals count from 1") end
  return { group = group, group_ordinal = ordinal }
end

-- Reads the marks behind a header that its flags announce, but not the words of the mask.
local function read_marks(c, set)
  if has(set, 0x02) then
    c:number(f.rate_period, 4)
    c:number(f.rate_ordinal, 4)
  end
  if has(set, 0x40) then return read_group_mark(c, set) end
  if has(set, 0x04) then
    if c:number(f.history_reader, 8) == UInt64(0) then c:fail("The id of a reader must not be 0") end
    c:number(f.history_oldest, 8)
  end
  if not has(set, 0x08) then return {} end
  local channel = c:number(f.channel, 4)
  c:number(f.sequence_high, 4)
  local ordinal = c:number(f.ordinal, 8)
  if ordinal == UInt64(0) then c:fail("Ordinals count from 1") end
  return { channel = channel, ordinal = ordinal }
end

-- Reads the words of a mask. The datagram does not contain the number of leaves of the type. So only the length of a
-- complete body shows where the words end.
local function read_mask_words(c, body_bytes)
  local words = math.floor((c:left() - body_bytes) / 8)
  for i = 0, words - 1 do
    local word, item = c:number(f.mask_word, 8)
    if word ~= nil then item:append_text(" (leaves " .. leaves_text(word, 64 * i) .. ")") end
  end
end

-- Returns true if the sample passed a gate that has conditions and no period. The position of `c` is behind the mask.
local function has_conditions(c, set)
  local rate_follows = has(set, 0x02) and c:left() >= 4
  return rate_follows and c.buffer(c.at, 4):le_uint() == 0
end

-- Returns true if a mask without words is more likely a hash than a list of leaves. A hash has about half of its bits
-- set, in about 16 runs. Fewer than 1 in 5000 hashes are missed. A list of leaves is taken for a hash only if it names
-- scattered fields of a type with about 50 leaves or more.
local function looks_like_hash(mask)
  local set, leaves = {}, 0
  add_leaves(set, mask, 0)
  for _ in pairs(set) do leaves = leaves + 1 end
  return mask:higher() >= 2 ^ 16 and leaves >= 17 and #runs_of(set, 0, 64) >= 9
end

-- Decides from the number of leaves of the publisher's type if a mask without words is a hash. Returns true, false, or
-- nil if the publisher is not known, or if most hashes could be lists of that many leaves.
local function is_hash_by_type(mask, writer)
  local leaves = known.leaves[writer]
  if not leaves then return nil end
  if leaves > 64 then return true end
  if leaves < 64 and mask:rshift(leaves) ~= UInt64(0) then return true end
  if leaves <= 48 then return false end
  return nil
end

-- Describes a mask that is a hash without words and that no request of the capture has. Without a gate, only a
-- selection with parts of fields has a hash. Retained samples have no gate, but the hash of a request that may have
-- conditions.
local function hash_text(c, set, writer)
  if has_conditions(c, set) then return "hash of a selection with conditions" end
  if (known.leaves[writer] or 0) > 2048 then return "hash of a long mask, or of a selection" end
  if has(set, 0x02) or has(set, 0x04) then return "hash of a selection with parts or conditions" end
  return "hash of a selection with parts"
end

-- Returns the request that a mask of this publisher stands for. Requests for other topics may have the same number. If
-- the topic of the publisher or of the subscriber is not known, it is the first request with that mask.
local function request_of(mask, writer)
  local key, topic = mask:tohex(), known.writers[writer]
  if not topic then return known.names[key] end
  return known.names[topic .. " " .. key] or known.names["? " .. key]
end

-- Explains a mask by the request that it stands for, and adds the frame of that request. Returns the meaning of the
-- mask.
local function add_request(c, range, request)
  if request.leaves then c.tree:add(f.leaves, range, request.leaves) end
  c.tree:add(f.selection, range, request.text):set_generated()
  c.tree:add(f.asked_in, range, request.frame):set_generated()
  return request.kind
end

-- Explains a mask, and returns its meaning. A datagram itself shows the meaning of a mask without words in two cases.
-- With conditions and no period, the mask is the hash of a selection. If several masks are merged, it is a list of
-- leaves. In other cases requests and announcements in the capture decide, and without them, the number itself.
local function explain_mask(c, set, writer, mask, range)
  local is_merged = has(set, 0x80)
  local request = not is_merged and request_of(mask, writer)
  if request then return add_request(c, range, request) end
  if has(set, 0x01) then return "hash of a mask" end
  local is_hash = not is_merged and is_hash_by_type(mask, writer)
  if is_hash or (has_conditions(c, set) and not is_merged) then return hash_text(c, set, writer) end
  if is_hash == nil and looks_like_hash(mask) then return "it looks like the " .. hash_text(c, set, writer) end
  c.tree:add(f.leaves, range, leaves_text(mask, 0))
  return is_hash == nil and "leaves, unless it is the " .. hash_text(c, set, writer) or "leaves"
end

local function read_mask(c, set, writer)
  local range = c:take(has(set, 0x20) and 2 or 8)
  if range == nil then return end
  local mask = range:le_uint64()
  local item = c.tree:add_le(f.mask, range)
  if range:len() == 8 and mask < UInt64(65536) then c:fail("A mask that needs two bytes must not have eight") end
  local meaning = explain_mask(c, set, writer, mask, range)
  item:append_text(" (" .. meaning .. ")")
  item:add(f.meaning, range, meaning):set_generated()
end

local function place_text(place)
  if place.group_ordinal then
    return string.format(" group=%u ordinal=%s", place.group, tostring(place.group_ordinal))
  end
  return place.ordinal and " ordinal=" .. tostring(place.ordinal) or ""
end

local function read_first(c, set, _, writer)
  local sequence = c:number(f.sequence, 4)
  local total = c:number(f.total, 4)
  c:stamp(f.stamp)
  read_mask(c, set, writer)
  local place = read_marks(c, set)
  if c.failed then return "" end
  if has(set, 0x01) and c:left() >= total then read_mask_words(c, total) end
  if not has(set, 0x01) and c:left() > total then c:fail("The payload is longer than the body") end
  local part = c:left() < total and " (begins)" or ""
  c:rest(f.payload)
  return string.format("seq=%u %u bytes%s", sequence, total, part) .. place_text(place)
end

-- Reads the 24 bits behind the kind of a whole datagram: flags, variant and channel.
local function read_short_place(c)
  local range = c:take(3)
  local bits = range:le_uint()
  local set = (has(bits, 0x1) and 0x01 or 0) + (has(bits, 0x2) and 0x80 or 0) + (has(bits, 0x4) and 0x20 or 0)
  local item = c.tree:add(f.flags, range, set)
  for _, flag in ipairs(flags) do item:add(flag.field, range, set) end
  c.tree:add(f.variant, range, math.floor(bits / 8) % 1024)
  c.tree:add(f.channel, range, math.floor(bits / 8192)):append_text(" (the low 11 bits of its number)")
  return set
end

local function read_whole(c, set, _, writer)
  local sequence = c:number(f.sequence, 4)
  local ordinal = c:number(f.ordinal, 4)
  if ordinal == 0 then c:fail("Ordinals count from 1") end
  c:stamp(f.stamp)
  read_mask(c, set, writer)
  if c.failed then return "" end
  local bytes = c:left()
  if has(set, 0x01) then
    c:rest(f.payload)  -- only the type determines where the words end
    return string.format("seq=%u ordinal=%u", sequence, ordinal)
  end
  c.tree:add(f.total, bytes):set_generated()
  c:rest(f.payload)
  return string.format("seq=%u %u bytes ordinal=%u", sequence, bytes, ordinal)
end

local function read_single(c, set, _, writer)
  local sequence = c:number(f.sequence, 4)
  c:stamp(f.stamp)
  read_mask(c, set, writer)
  if c.failed then return "" end
  local bytes = c:left()
  c.tree:add(f.total, bytes):set_generated()
  c:rest(f.payload)
  return string.format("seq=%u %u bytes", sequence, bytes)
end

-- Reads the variant of a following datagram, which has no flags.
local function read_near_variant(c)
  c:number(f.variant, 1)
  return 0
end

local function read_part(c, offset_bytes)
  local sequence = c:number(f.sequence, 4)
  local offset = c:number(f.offset, offset_bytes)
  if not c.failed and c:left() == 0 then c:fail("A following datagram has at least one byte of payload") end
  if c.failed then return "" end
  local bytes = c:left()
  c:rest(f.payload)
  return string.format("seq=%u bytes %u to %.0f", sequence, offset, offset + bytes)
end
local function read_following(c) return read_part(c, 3) end
local function read_far(c) return read_part(c, 4) end

local function read_heartbeat(c)
  local channel = c:number(f.channel, 4)
  c:number(f.waiting, 4)
  local first = c:number(f.first, 8)
  local end_ = c:number(f.end_, 8)
  if c.failed then return "" end
  if first == UInt64(0) then c:fail("Ordinals count from 1") end
  if end_ < first then c:fail("The end must not be before the first ordinal") end
  if c:left() > 0 then c:fail("A heartbeat has 32 bytes") end
  return string.format("channel=%u has [%s, %s)", channel, tostring(first), tostring(end_))
end

local function read_ack(c, _, parts)
  local channel = c:number(f.channel, 4)
  c:number(f.reserved, 4)
  local next = c:number(f.next, 8)
  if next == UInt64(0) then c:fail("Ordinals count from 1") end
  local tree = c.tree
  for _ = 1, parts or 0 do
    local range = c.failed and nil or c:take(12)
    if range == nil then break end
    local ordinal, from, to = range(0, 4):le_uint(), range(4, 4):le_uint(), range(8, 4):le_uint()
    local item = tree:add(f.missing, range)
    item:add_le(f.missing_ordinal, range(0, 4))
    item:add_le(f.missing_begin, range(4, 4))
    item:add_le(f.missing_end, range(8, 4))
    item:set_text(from == to and string.format("Missing: all of %u", ordinal)
                              or string.format("Missing: of %u bytes %u to %u", ordinal, from, to))
    if from > to then c:fail("A missing part ends before it begins") end
  end
  if c.failed then return "" end
  if c:left() > 0 then c:fail("The ack is longer than its number of parts") end
  if parts > 0 then tree:add_proto_expert_info(loss, "The reader asks for " .. parts .. " parts again") end
  return string.format("channel=%u next=%s missing=%u", channel, tostring(next), parts)
end

-- Reads the bodies of packed samples. Each has `each` bytes, or if `each` is 0, a length in front of it.
local function read_samples(c, sequence, place, samples, each)
  for i = 0, samples - 1 do
    local at, bytes = c.at, each
    if each == 0 then
      local length = c:take(2)
      if length == nil then return end
      bytes = length:le_uint()
    end
    local body = c:take(bytes)
    if c.failed then return end
    local item = c.tree:add(f.sample, c.buffer(at, c.at - at))
    item:set_text(string.format("Sample %u: %u bytes", (sequence + i) % 2 ^ 32, bytes))
    item:add(f.length, bytes):set_generated()
    if place.ordinal then item:add(f.ordinal, place.ordinal + UInt64(i)):set_generated() end
    if bytes > 0 then item:add(f.payload, body) end
  end
end

local function read_packed(c, set, _, writer)
  local sequence = c:number(f.sequence, 4)
  local samples = c:number(f.samples, 2)
  local each = c:number(f.bytes_each, 2)
  c:stamp(f.stamp)
  read_mask(c, set, writer)
  local place = read_marks(c, set)
  if c.failed then return "" end
  local lengths = has(set, 0x10)
  if samples == 0 or samples > 256 then c:fail("A packed datagram has 1 to 256 samples") end
  if lengths ~= (each == 0) then c:fail("All samples have the same length, or lengths follow; not both") end
  if has(set, 0x01) and not lengths then read_mask_words(c, samples * each) end
  if has(set, 0x01) and lengths then
    c:rest(f.payload)  -- only the type determines where the words end
  else
    read_samples(c, sequence, place, samples, each)
  end
  if c.failed then return "" end
  if c:left() > 0 and not lengths then c:fail("The datagram is longer than its number of samples") end
  c:rest(f.padding)
  return string.format("seq=%u and %u more", sequence, samples - 1) .. place_text(place)
end

-- Reads a mark or a report. A report repeats most of a mark.
local function read_flow(c, report)
  local position = c:number(f.position, 8)
  local window = c:number(report and f.window or f.reserved, 4)
  c:number(f.datagrams, 4)
  c:number(report and f.came or f.reserved, 4)
  c:number(report and f.longest or f.reserved, 4)
  c:number(f.sent_at, 8)
  if c.failed then return "" end
  if c:left() > 0 then c:fail("Marks and reports have 40 bytes") end
  return "position=" .. tostring(position) .. (report and string.format(" window=%u", window) or "")
end
local function read_mark(c) return read_flow(c, false) end
local function read_report(c) return read_flow(c, true) end

-- Reads an address. Its lowest byte comes first, as in all numbers.
local function read_address(c)
  local range = c:take(4)
  if range == nil then return nil end
  local number = range:le_uint()
  local item = c.tree:add_le(f.group_address, range)
  if number == 0 then
    item:append_text(" (the member has left the group)")
  elseif math.floor(number / 65536) ~= 0xefff then
    c:fail("The address of a group must be in 239.255.0.0/16")
  end
  return number
end

local function read_group_offer(c)
  local group = c:number(f.group, 4)
  local member = c:number(f.member, 4)
  local address = read_address(c)
  local channel = c:number(f.channel, 4)
  local range = c:take(8)
  if range == nil then return "" end
  local ahead = range:le_int64()
  c.tree:add_le(f.ahead, range)
  if c:left() > 0 then c:fail("A group offer has 32 bytes") end
  if address == 0 then return string.format("group=%u member=%u no more", group, member) end
  return string.format("group=%u member=%u channel=%u ahead=%s", group, member, channel, tostring(ahead))
end

local function read_group_report(c)
  local group = c:number(f.group, 4)
  local member = c:number(f.member, 4)
  local heard = c:number(f.heard, 8)
  if c.failed then return "" end
  if c:left() > 0 then c:fail("A group report has 24 bytes") end
  if heard == UInt64(0) then return string.format("group=%u member=%u offer again", group, member) end
  return string.format("group=%u member=%u heard=%s", group, member, tostring(heard))
end

local function read_group_probe(c)
  local group = c:number(f.group, 4)
  c:number(f.reserved, 4)
  local ordinal = c:number(f.group_ordinal, 8)
  if c.failed then return "" end
  if c:left() > 0 then c:fail("A group probe has 24 bytes") end
  if ordinal == UInt64(0) then c:fail("The ordinal of a probe is not 0") end
  return string.format("group=%u ordinal=%s", group, tostring(ordinal))
end

-- The kinds of datagrams by number. `at_2` is the field at offset 2; or `from_1` is a function that reads everything
-- between the kind and the writer, and returns the flags. `at_4` is the field at offset 4 if that is not the writer.
-- `flags` may be set, `bytes` is the least length, and `read` is the function that reads the rest.
local kinds = {
  [1] = { name = "first", at_2 = f.variant, flags = 0xef, bytes = 26, read = read_first },
  [2] = { name = "following", from_1 = read_near_variant, flags = 0xff, bytes = 14, read = read_following },
  [3] = { name = "heartbeat", at_2 = f.port, flags = 0, bytes = 32, read = read_heartbeat },
  [4] = { name = "ack", at_2 = f.parts, flags = 0, bytes = 24, read = read_ack },
  [5] = { name = "packed", at_2 = f.variant, flags = 0x39, bytes = 27, read = read_packed },
  [6] = { name = "group offer", at_2 = f.group_port, flags = 0, bytes = 32, read = read_group_offer },
  [7] = { name = "group report", at_2 = f.reserved_short, flags = 0, bytes = 24, read = read_group_report },
  [8] = { name = "mark", at_2 = f.port, at_4 = f.flow, flags = 0, bytes = 40, read = read_mark },
  [9] = { name = "report", at_2 = f.reserved_short, at_4 = f.flow, flags = 0, bytes = 40, read = read_report },
  [10] = { name = "whole", from_1 = read_short_place, flags = 0xff, bytes = 26, read = read_whole },
  [11] = { name = "group probe", at_2 = f.reserved_short, flags = 0, bytes = 24, read = read_group_probe },
  [12] = { name = "single", at_2 = f.variant, flags = 0xa0, bytes = 22, read = read_single },
  [13] = { name = "far", at_2 = f.variant, flags = 0, bytes = 17, read = read_far },
}

local function add_flags(c, kind)
  local range = c:take(1)
  local set = range:uint()
  local item = c.tree:add(f.flags, range)
  for _, flag in ipairs(flags) do item:add(flag.field, range) end
  for bit = 0, 7 do
    if has(set, 2 ^ bit) and not has(kind.flags, 2 ^ bit) then
      c:fail("A " .. kind.name .. " datagram must not have flag bit " .. bit)
    end
  end
  return set
end

function sft.dissector(buffer, pinfo, root)
  local tree = root:add(sft, buffer())
  local c = Cursor.new(buffer, tree)
  pinfo.cols.protocol = "SFT"
  if buffer:len() < common_bytes then
    c:fail("The datagram is shorter than any header")
    return
  end
  local first_byte = c:take(1)
  local number = first_byte:bitfield(4, 4)
  local kind = kinds[number]
  tree:add(f.version, first_byte)
  tree:add(f.kind, first_byte):append_text(kind and " (" .. kind.name .. ")" or "")
  if first_byte:bitfield(0, 4) ~= wire_version then c:fail("The version is not " .. wire_version) end
  if kind == nil then c:fail("The kind is unknown") end
  if c.failed then return buffer:len() end
  local set = (kind.from_1 or add_flags)(c, kind)
  if c.failed then return buffer:len() end
  local at_2 = kind.at_2 and c:number(kind.at_2, 2)
  local writer = c:number(kind.at_4 or f.writer, 4)
  local what = kind.read(c, set, at_2, writer)
  local text = string.format("%s %s=%08x %s", kind.name, kind.at_4 and "flow" or "writer", writer, what)
  if c.failed then text = text .. " [malformed]" end
  if not c.failed and not kind.at_4 and number ~= 2 and number ~= 13 then known.heard[writer] = true end
  pinfo.cols.info = text
  tree:append_text(": " .. text)
  return buffer:len()
end

-- Returns true if a first datagram may have these flags and this length.
local function plausible_flags(set, bytes)
  if has(set, 0x40) then return bytes >= 42 and not (has(set, 0x04) or has(set, 0x08)) end
  return bytes >= 42 or not has(set, 0x08)
end
-- Returns true if these are the upper bytes of a stamp from 1970 to 2100.
local function plausible_stamp(range) return range:le_uint() < 0x39000000 end
-- Returns true if a whole datagram has an ordinal and a plausible stamp. Any flags are possible.
local function plausible_whole(buffer) return buffer(12, 4):le_uint() ~= 0 and plausible_stamp(buffer(20, 4)) end
local function plausible_address(address) return address == 0 or math.floor(address / 65536) == 0xefff end

-- Returns true if the other bytes of a datagram whose first bytes look like SFT are plausible, too.
local function plausible(buffer, number)
  if number == 1 then return plausible_flags(buffer(1, 1):uint(), buffer:len()) end
  -- Any bytes are possible in these kinds, so that the publisher must be known from other datagrams.
  if number == 2 then return known.heard[buffer(2, 4):le_uint()] == true end
  if number == 13 then return known.heard[buffer(4, 4):le_uint()] == true end
  if number == 3 then return buffer:len() == 32 and buffer(12, 4):le_uint() == 0 end
  if number == 4 then return buffer:len() == 24 + 12 * buffer(2, 2):le_uint() end
  if number == 5 then return buffer(12, 2):le_uint() >= 1 and buffer(12, 2):le_uint() <= 256 end
  if number == 6 then return buffer:len() == 32 and plausible_address(buffer(16, 4):le_uint()) end
  if number == 7 then return buffer:len() == 24 end
  if number == 8 or number == 9 then return buffer:len() == 40 end
  if number == 10 then return plausible_whole(buffer) end
  if number == 12 then return plausible_stamp(buffer(16, 4)) end
  return true
end

local function looks_like_sft(buffer, pinfo, tree)
  if buffer:len() < common_bytes then return false end
  local kind = kinds[buffer(0, 1):bitfield(4, 4)]
  if buffer(0, 1):bitfield(0, 4) ~= wire_version or kind == nil or buffer:len() < kind.bytes then return false end
  local set = buffer(1, 1):uint()
  for bit = 0, 7 do
    if has(set, 2 ^ bit) and not has(kind.flags, 2 ^ bit) then return false end
  end
  if not plausible(buffer, buffer(0, 1):bitfield(4, 4)) then return false end
  sft.dissector(buffer, pinfo, tree)
  return true
end

sft:register_heuristic("udp", looks_like_sft)
DissectorTable.get("udp.port"):add_for_decode_as(sft)

-- Heartbeats of participants (core/discovery/heartbeat.h). Their numbers are little-endian.
local heartbeat = Proto("sft_heartbeat", "SFT heartbeat")
local heartbeat_bytes = 44
local h = {
  version = ProtoField.uint8("sft_heartbeat.version", "Version"),
  participant = ProtoField.bytes("sft_heartbeat.participant", "Participant"),
  process = ProtoField.uint64("sft_heartbeat.process", "Process", base.HEX),
  writers = ProtoField.uint64("sft_heartbeat.digest_of_writers", "Digest of the records about publishers", base.HEX),
  readers = ProtoField.uint64("sft_heartbeat.digest_of_readers", "Digest of the records about subscribers", base.HEX),
}
heartbeat.fields = h

local function is_heartbeat(buffer) return buffer:len() >= heartbeat_bytes and buffer(0, 3):string() == "SHB" end

local function read_heartbeat_of_process(buffer, tree)
  local item = tree:add(heartbeat, buffer(0, heartbeat_bytes))
  item:add(h.version, buffer(3, 1))
  item:add(h.participant, buffer(4, 16))
  item:add_le(h.process, buffer(20, 8))
  item:add_le(h.writers, buffer(28, 8))
  item:add_le(h.readers, buffer(36, 8))
  return "Process 0x" .. buffer(20, 8):le_uint64():tohex() .. " lives"
end

-- Dissects a heartbeat on the topic sft_heartbeat, in a sample of RTPS.
function heartbeat.dissector(buffer, pinfo, tree)
  if not is_heartbeat(buffer) then return 0 end
  pinfo.cols.info:append(" [" .. read_heartbeat_of_process(buffer, tree) .. "]")
  return heartbeat_bytes
end

local function looks_like_heartbeat(buffer, pinfo, tree)
  if buffer:len() ~= heartbeat_bytes or not is_heartbeat(buffer) then return false end
  pinfo.cols.protocol = "SFT heartbeat"
  pinfo.cols.info = read_heartbeat_of_process(buffer, tree)
  return true
end

heartbeat:register_heuristic("udp", looks_like_heartbeat)

-- Control samples: the records of a process about its publishers, on the topic sft_writer, and about its subscribers
-- and their requests, on the topic sft_reader. The samples are little-endian CDR (XCDR1). They contain the bodies of
-- core/control/record_body.h, whose members have no padding between them.
local control = Proto("sft_control", "SFT control sample")

local control_version = 16
local struct_depth_max = 64
local conditions_max, condition_depth_max = 32, 8
local parts_max = 16
local leaves_max = 4096

local roles = { [0] = "publisher", [1] = "subscriber" }
local kinds_of_records = { [0] = "announcement", [1] = "request", [2] = "inquiry" }
local g = {
  participant = ProtoField.bytes("sft_control.participant", "Participant"),
  slot = ProtoField.uint32("sft_control.slot", "Slot"),
  kind = ProtoField.uint8("sft_control.kind", "Kind", base.DEC, kinds_of_records),
  body = ProtoField.none("sft_control.body", "Body"),
  reader = ProtoField.uint64("sft_control.reader", "Subscriber", base.HEX),
  wants_accounts = ProtoField.bool("sft_control.inquiry.wants_accounts", "Wants accounts of pairs, not progress"),
  id = ProtoField.uint64("sft_control.id", "Id", base.HEX),
  version = ProtoField.uint8("sft_control.version", "Version"),
  role = ProtoField.uint8("sft_control.role", "Role", base.DEC, roles),
  node = ProtoField.uint64("sft_control.node", "Node", base.HEX),
  node_name = ProtoField.string("sft_control.node_name", "Name of the node"),
  topic = ProtoField.string("sft_control.topic", "Topic"),
  given_topic = ProtoField.string("sft_control.given_topic", "Topic as its program names it"),
  type_name = ProtoField.string("sft_control.type_name", "Type"),
  type_hash = ProtoField.uint64("sft_control.type_hash", "Hash of the type", base.HEX),
  description = ProtoField.bytes("sft_control.type_description", "Type description"),
  host = ProtoField.bytes("sft_control.host", "Host token"),
  memory_failure = ProtoField.string("sft_control.memory_failure", "Shared memory failed"),
  network = ProtoField.uint64("sft_control.network", "Network", base.HEX),
  may_use_shm = ProtoField.bool("sft_control.may_use_shm", "May use shared memory"),
  may_use_udp = ProtoField.bool("sft_control.may_use_udp", "May use UDP"),
  address = ProtoField.none("sft_control.address", "Address"),
  wireless = ProtoField.bool("sft_control.address.wireless", "Wireless"),
  ipv4 = ProtoField.ipv4("sft_control.address.ipv4", "IPv4 address"),
  ipv6 = ProtoField.ipv6("sft_control.address.ipv6", "IPv6 address"),
  port = ProtoField.uint16("sft_control.address.port", "Port"),
  receive_buffer = ProtoField.uint32("sft_control.address.receive_buffer", "Bytes of the receive buffer"),
  doorbell_page = ProtoField.uint64("sft_control.doorbell.page", "Page of the doorbell", base.HEX),
  doorbell_slot = ProtoField.uint32("sft_control.doorbell.slot", "Slot of the doorbell"),
  max_sample = ProtoField.uint64("sft_control.max_sample_bytes", "Bytes of the largest body"),
  waits = ProtoField.bool("sft_control.waits", "Waits for reliable subscribers"),
  reliability = ProtoField.uint8("sft_control.reliability", "Reliability", base.DEC,
                                 { [0] = "best effort", [1] = "reliable" }),
  durability = ProtoField.uint8("sft_control.durability", "Durability", base.DEC,
                                { [0] = "volatile", [1] = "transient local" }),
  liveliness = ProtoField.uint8("sft_control.liveliness", "Liveliness", base.DEC,
                                { [0] = "automatic", [1] = "manual by topic" }),
  deadline = ProtoField.uint64("sft_control.deadline_ns", "Deadline (ns, 0: none)"),
  liveliness_lease = ProtoField.uint64("sft_control.liveliness_lease_ns", "Lease of the liveliness (ns, 0: none)"),
  lifespan = ProtoField.uint64("sft_control.lifespan_ns", "Lifespan (ns, 0: none)"),
  history_depth = ProtoField.uint32("sft_control.history_depth", "Depth of the history"),
  revision = ProtoField.uint64("sft_control.revision", "Revision"),
  request_sequence = ProtoField.uint64("sft_control.request.sequence", "Sequence of the request"),
  mask_word = ProtoField.uint64("sft_control.request.mask_word", "Mask word", base.HEX),
  listening = ProtoField.uint64("sft_control.request.listening", "Listens to the publisher", base.HEX),
  attached = ProtoField.uint64("sft_control.request.attached", "Attached in shared memory to the publisher", base.HEX),
  begun = ProtoField.uint64("sft_control.request.begun", "Got retained samples of the publisher", base.HEX),
  name = ProtoField.uint64("sft_control.request.name", "Mask in datagrams", base.HEX),
  selection = ProtoField.string("sft_control.request.selection", "Asks for"),
  wants = ProtoField.none("sft_control.want", "Parts of fields, and conditions"),
  period = ProtoField.uint32("sft_control.want.period_us", "One sample at most for each period of (us, 0: all)"),
  leaves = ProtoField.string("sft_control.want.leaves", "Leaves"),
  field_part = ProtoField.none("sft_control.want.part", "Part of a field"),
  leaf = ProtoField.uint32("sft_control.want.part.leaf", "Leaf"),
  rule = ProtoField.uint32("sft_control.want.part.rule", "Hash of the layout rule", base.HEX),
  rows = ProtoField.string("sft_control.want.part.rows", "Rows"),
  columns = ProtoField.string("sft_control.want.part.columns", "Columns or elements"),
  channel = ProtoField.string("sft_control.want.part.channel", "Channel"),
  condition = ProtoField.none("sft_control.want.condition", "Condition"),
  rate = ProtoField.string("sft_control.want.rate", "Rate"),
}
control.fields = g

local control_malformed = ProtoExpert.new("sft_control.malformed", "Malformed", expert.group.MALFORMED,
                                          expert.severity.ERROR)
control.experts = { control_malformed }

-- Returns the number of items of a list. Each item has at least `bytes_each` bytes.
function Cursor:count(bytes_each)
  local range = self:take(4)
  local count = range and range:le_uint() or 0
  if count * bytes_each <= self:left() then return count end
  self:fail("A list has more items than there are bytes")
  return 0
end
function Cursor:ids(field)
  for _ = 1, self:count(8) do self:number(field, 8) end
end
function Cursor:text(field)
  local range = self:take(1)
  local bytes = range and range:uint() or 0
  if bytes > 0 then range = self:take(bytes) end
  if range == nil then return "" end
  local text = bytes > 0 and range:string(ENC_UTF_8) or ""
  self.tree:add(field, range, text)
  return text
end
function Cursor:byte()
  local range = self:take(1)
  return range and range:uint() or 0
end
-- Reads an unsigned LEB128. Superfluous bytes are an error.
function Cursor:leb()
  local value = UInt64(0)
  for i = 0, 9 do
    local byte = self:byte()
    if self.failed or (i == 9 and byte > 1) or (i > 0 and byte == 0) then break end
    value = value + UInt64(byte % 128):lshift(7 * i)
    if byte < 128 then return value end
  end
  self:fail("A number has superfluous bytes, or more than 64 bits")
  return UInt64(0)
end
function Cursor:leb_of_32_bits()
  local value = self:leb()
  if value:higher() > 0 then self:fail("A number has more than 32 bits") end
  return self.failed and 0 or value:lower()
end
-- Returns the number of items that follow. Each has at least one byte.
function Cursor:several()
  local count = self:leb_of_32_bits()
  if count <= self:left() then return count end
  self:fail("There are more things than bytes")
  return 0
end
function Cursor:short_text()
  local bytes = self:several()
  local range = bytes > 0 and self:take(bytes)
  return range and range:string(ENC_UTF_8) or "", range
end
-- Calls read() with an item of its own in the tree, which covers the bytes that read() takes. The first result of
-- read() becomes the text of the item, unless it is nil. Returns the results of read().
function Cursor:within(field, read)
  if self:left() <= 0 then self:take(1) end
  if self.failed then return nil end
  local outer, begin = self.tree, self.at
  local item = outer:add(field, self.buffer(begin))
  self.tree = item
  local text, result = read()
  item:set_len(self.at - begin)
  if text then item:set_text(text) end
  self.tree = outer
  return text, result
end
-- Returns the bytes from `begin` to the present position as a string.
function Cursor:raw_from(begin) return self.at > begin and self.buffer:raw(begin, self.at - begin) or "" end

-- FNV-1a, as in sft/detail/fnv1a.h. It is the hash in datagrams that stands for a long mask or a selection.
local fnv_begin, fnv_prime = UInt64(0x84222325, 0xcbf29ce4), UInt64(0x1b3, 0x100)
local function mix(hash, raw)
  for i = 1, #raw do hash = hash:bxor(UInt64(raw:byte(i))) * fnv_prime end
  return hash
end
local function mix_word(hash, word)
  for i = 0, 7 do hash = hash:bxor(word:rshift(8 * i):band(UInt64(0xff))) * fnv_prime end
  return hash
end
local function hash_of(raw) return mix(mix_word(fnv_begin, UInt64(#raw)), raw) end
local function hash_of_both(a, b) return mix_word(mix_word(fnv_begin, a), b) end

-- Returns the number that stands for a request in datagrams (FieldMask::hash(), Selection::hash()).
local function name_of(asked)
  local name = asked.words[1] or UInt64(0)
  if #asked.words > 1 then
    name = fnv_begin
    for _, word in ipairs(asked.words) do name = mix_word(name, word) end
  end
  if asked.parts_raw ~= "" then name = hash_of_both(name, hash_of(asked.parts_raw)) end
  if asked.conditions_raw == "" then return name end
  local gate = hash_of(asked.conditions_raw)
  return hash_of_both(name, gate == UInt64(0) and UInt64(1) or gate)
end

-- Type descriptions (typesupport/runtime/type_description.md), from which leaves get their names.

-- Adds the leaves and the nodes of a struct to a type. A node is a path with the leaves below it. `scalars` has the
-- leaves that are single values and not in a list.
local function flatten(type, struct, prefix, is_in_list)
  local function add_leaf(path, is_scalar)
    type.scalars[type.leaves] = is_scalar or nil
    type.nodes[#type.nodes + 1] = { path = path, first = type.leaves, count = 1, is_leaf = true }
    type.paths[type.leaves] = path
    type.leaves = type.leaves + 1
  end
  for _, member in ipairs(struct.members) do
    local path, inner = prefix .. member.name, member.struct
    if inner == nil then
      add_leaf(path, member.shape == 0 and not is_in_list)
    else
      local has_size, is_list = member.shape == 2, member.shape > 0
      type.nodes[#type.nodes + 1] = { path = path, first = type.leaves, count = inner.leaves + (has_size and 1 or 0) }
      if has_size then add_leaf(path .. ".size", false) end
      if is_list then path = path .. "[]" end
      if is_list then type.nodes[#type.nodes + 1] = { path = path, first = type.leaves, count = inner.leaves } end
      flatten(type, inner, path .. ".", is_in_list or is_list)
    end
  end
  return type
end

local function skip_attributes(c, shape)
  local attributes = c:byte()
  if has(attributes, 0x01) then c:leb() end
  if has(attributes, 0x02) then c:leb() end
  if has(attributes, 0x04) then c:leb() end
  if has(attributes, 0x08) then c:short_text() end
  if has(attributes, 0x10) then c:short_text() end
  if attributes == 0 or attributes > 0x1f or (has(attributes, 0x01) and shape ~= 2) then
    c:fail("A member has attributes that are unknown")
  end
end

local function read_member(c, structs)
  local form = c:byte()
  local kind, member = form % 16, { name = c:short_text(), shape = math.floor(form / 16) % 4 }
  if kind > 14 or member.shape > 2 then c:fail("A member has a kind or a shape that is unknown") end
  if member.shape == 1 then c:leb() end
  if kind == 14 then
    member.struct = structs[c:leb_of_32_bits() + 1]
    if member.struct == nil then c:fail("A member is of a struct that does not stand before it") end
  end
  if has(form, 0x80) then skip_attributes(c, member.shape) end
  return member
end

local function read_struct(c, structs)
  local struct = { members = {}, leaves = 0, depth = 1 }
  c:short_text()
  for i = 1, c:several() do
    local member = read_member(c, structs)
    if c.failed then return nil end
    struct.members[i] = member
    struct.leaves = struct.leaves + (member.struct and member.struct.leaves or 1)
    if member.struct and member.shape == 2 then struct.leaves = struct.leaves + 1 end
    struct.depth = math.max(struct.depth, member.struct and member.struct.depth + 1 or 1)
    if struct.leaves > leaves_max or struct.depth > struct_depth_max then c:fail("The type is too large") end
  end
  return struct
end

local function skip_enumeration(c)
  c:short_text()
  c:byte()
  for _ = 1, c:several() do
    c:short_text()
    c:leb()
    if c.failed then return end
  end
end

-- Returns the type, or nil if its description is malformed.
local function read_description(c)
  if c:byte() ~= 1 then c:fail("The version of the type description is not 1") end
  for _ = 1, c:several() do
    skip_enumeration(c)
    if c.failed then return nil end
  end
  local structs = {}
  for i = 1, c:several() do
    structs[i] = read_struct(c, structs)
    if c.failed then return nil end
  end
  if #structs == 0 or c:left() > 0 then c:fail("The type description does not end with its last struct") end
  if c.failed then return nil end
  return flatten({ leaves = 0, paths = {}, nodes = {}, scalars = {} }, structs[#structs], "", false)
end

-- Selections as text (typesupport/runtime/selection.md). Without the type, leaves have numbers instead of names.

local function path_of(type, leaf) return type and type.paths[leaf] or string.format("leaf %d", leaf) end

local function has_all(set, node)
  for leaf = node.first, node.first + node.count - 1 do
    if not set[leaf] then return false end
  end
  return true
end

-- Returns the fields of a request as text, without conditions. `asked.parts` has the texts of parts, by leaf.
local function fields_text(asked, type)
  local whole, texts, covered = {}, {}, 0
  for leaf in pairs(asked.set) do whole[leaf] = asked.parts[leaf] == nil or nil end
  if type then
    if has_all(whole, { first = 0, count = type.leaves }) then return "*" end
    for _, node in ipairs(type.nodes) do
      local part = node.is_leaf and asked.parts[node.first]
      if node.first >= covered and (part or has_all(whole, node)) then
        texts[#texts + 1] = node.path .. (part or "")
        covered = node.first + node.count
      end
    end
  else
    if next(whole) then texts[1] = "leaves " .. runs_text(whole, 0, 64 * #asked.words) end
    for leaf = 0, 64 * #asked.words - 1 do
      if asked.parts[leaf] then texts[#texts + 1] = path_of(nil, leaf) .. asked.parts[leaf] end
    end
  end
  return #texts == 0 and "no fields" or table.concat(texts, ", ")
end

local function duration_text(us)
  local units = { { 60000000, "min" }, { 1000000, "s" }, { 1000, "ms" } }
  for _, unit in ipairs(units) do
    if us % unit[1] == 0 then return string.format("%.0f %s", us / unit[1], unit[2]) end
  end
  return string.format("%.0f us", us)
end

local function rate_text(us)
  if us <= 1000000 and 1000000 % us == 0 then return string.format("at most %.0f Hz", 1000000 / us) end
  return "at most one per " .. duration_text(us)
end

local function ordinal_text(n)
  local last = n % 10
  local is_teen = math.floor(n % 100 / 10) == 1
  local endings = { "st", "nd", "rd" }
  return string.format("%.0f", n) .. (not is_teen and endings[last] or "th")
end

-- Returns the shortest text of a real number that is read as the same number.
local function real_text(number)
  for digits = 1, 16 do
    local text = string.format("%." .. digits .. "g", number)
    if tonumber(text) == number then return text end
  end
  return string.format("%.17g", number)
end

-- Reads a range of indices. Returns its text, or nil if no range follows.
local function read_range(c, field, follows)
  if not follows then return nil end
  local at = c.at
  local begin, end_, step = c:leb_of_32_bits(), c:leb_of_32_bits(), c:leb_of_32_bits()
  if c.failed then return nil end
  local is_empty, is_open = step == 0, end_ == 0
  if is_empty and (begin ~= 0 or end_ ~= 0) then c:fail("An empty range is 0 to 0") end
  if not is_empty and is_open and begin == 0 and step == 1 then c:fail("A range of all indices is not written") end
  if not is_open and not is_empty then
    local count = end_ - begin
    local is_least = count > 0 and (count - 1) % step == 0 and (count > 1 or step == 1)
    if not is_least then c:fail("A range ends behind the last index that it keeps") end
  end
  local text = (begin > 0 and string.format("%d", begin) or "") .. ":" .. (is_open and "" or string.format("%d", end_))
  if step > 1 then text = text .. string.format(":%d", step) end
  if is_empty then text = "0:0" elseif end_ == begin + 1 then text = string.format("%d", begin) end
  c.tree:add(field, c.buffer(at, c.at - at), text)
  return text
end

-- Returns true if `a` is before `b` in the order of bytes. Lua's own comparison depends on the user's locale.
local function is_before(a, b)
  for i = 1, math.min(#a, #b) do
    if a:byte(i) ~= b:byte(i) then return a:byte(i) < b:byte(i) end
  end
  return #a < #b
end

local function read_channels(c)
  local names = {}
  for i = 1, c:several() do
    local name, range = c:short_text()
    if c.failed then return "" end
    if not range or (i > 1 and not is_before(names[i - 1], name)) then
      c:fail("The names of channels ascend, and none is empty")
      return ""
    end
    c.tree:add(g.channel, range, name)
    names[i] = name
  end
  if #names == 0 then c:fail("There are no channels") end
  return "{" .. table.concat(names, ",") .. "}"
end

-- Reads the part of one field into `parts`. Returns its text and its leaf.
local function read_part(c, parts, type)
  local flags_at = c.at
  local follows = c:byte()
  if follows > 0x0f or follows % 8 == 0 then c:fail("A part says what is unknown, or nothing") end
  local leaf = c:leb_of_32_bits()
  if c.failed then return nil end
  c.tree:add(g.leaf, c.buffer(flags_at + 1, c.at - flags_at - 1), leaf):append_text(
    type and " (" .. path_of(type, leaf) .. ")" or "")
  if has(follows, 0x08) then
    local at = c.at
    local rule = c:leb_of_32_bits()
    if rule == 0 then c:fail("A layout rule of 0 is not written") end
    c.tree:add(g.rule, c.buffer(at, c.at - at), rule)
  end
  local rows = read_range(c, g.rows, has(follows, 0x01))
  local columns = read_range(c, g.columns, has(follows, 0x02))
  local text = has(follows, 0x04) and read_channels(c) or ""
  if rows then
    text = text .. "[rows " .. rows .. (columns and ", columns " .. columns or "") .. "]"
  elseif columns then
    text = text .. "[" .. columns .. "]"
  end
  parts[leaf] = text
  return path_of(type, leaf) .. text, leaf
end

local function read_parts(c, asked, set, type)
  local begin, last = c.at, -1
  local count = c:several()
  if count == 0 or count > parts_max then c:fail("There are 1 to " .. parts_max .. " parts") end
  for _ = 1, count do
    local _, leaf = c:within(g.field_part, function() return read_part(c, asked.parts, type) end)
    if c.failed then return end
    if leaf <= last then c:fail("The leaves of parts ascend") end
    if not set[leaf] then c:fail("The leaf of a part is not in the mask") end
    last = leaf
  end
  asked.parts_raw = c:raw_from(begin)
end

-- Reads the number of a condition. Returns its text, and its value if it is a natural number.
local function read_number(c)
  local form = c:byte()
  if form == 1 then
    local number = c:leb()
    return tostring(number), number
  elseif form == 2 then
    local number = c:leb()
    if number:higher() >= 2 ^ 31 then c:fail("A negative number has more than 64 bits") end
    return "-" .. tostring(number + UInt64(1))
  elseif form == 3 then
    local range = c:take(8)
    return range and real_text(range:le_float()) or ""
  end
  c:fail("A number has an unknown form")
  return ""
end

-- Returns true if the leaves are all single values of the mask. `changed` without names means these.
local function are_all_scalars(leaves, set, type)
  if type == nil then return false end
  local scalars = 0
  for leaf in pairs(type.scalars) do
    if set[leaf] then scalars = scalars + 1 end
  end
  for _, leaf in ipairs(leaves) do
    if not (type.scalars[leaf] and set[leaf]) then return false end
  end
  return scalars == #leaves
end

local function changed_text(leaves, deadband, percent, set, type)
  local names = {}
  for i, leaf in ipairs(leaves) do names[i] = path_of(type, leaf) end
  local text = "changed" .. (are_all_scalars(leaves, set, type) and "" or "(" .. table.concat(names, ", ") .. ")")
  return deadband == "0" and text or text .. " " .. deadband .. (percent and "%" or "")
end

local comparisons = { [0] = "<", "<=", ">", ">=", "==", "!=" }

-- Reads a condition that contains no other conditions. Returns its text.
local function read_term(c, kind, comparison, percent, set, type)
  local leaves = {}
  for i = 1, c:several() do leaves[i] = c:leb_of_32_bits() end
  local number, natural = read_number(c)
  if c.failed then return "" end
  if kind == 2 and #leaves == 1 and comparisons[comparison] then
    return path_of(type, leaves[1]) .. " " .. comparisons[comparison] .. " " .. number
  elseif kind == 3 and #leaves > 0 then
    return changed_text(leaves, number, percent, set, type)
  elseif (kind == 4 or kind == 5) and #leaves == 0 and natural and natural > UInt64(0) then
    return "every " .. (kind == 4 and ordinal_text or duration_text)(natural:tonumber())
  end
  c:fail("A condition is none that a selection can have")
  return ""
end

-- Reads a condition and those in it. `tree.left` counts the conditions that are still to be read. Returns the text.
local function read_condition(c, tree, depth, outer)
  local at = c.at
  local form = c:byte()
  local kind, comparison, percent = form % 8, math.floor(form / 8) % 8, has(form, 0x40)
  tree.left = tree.left - 1
  if has(form, 0x80) or (comparison > 0 and kind ~= 2) or (percent and kind ~= 3) then
    c:fail("A condition says what its kind does not have")
  end
  if kind > 1 then return read_term(c, kind, comparison, percent, tree.set, tree.type) end
  local texts, children = {}, c:leb_of_32_bits()
  if children < 2 or children > tree.left then c:fail("There are fewer conditions than stand in others") end
  if depth >= condition_depth_max then c:fail("Conditions lie too deep in each other") end
  for i = 1, children do
    if c.failed or tree.left == 0 then break end
    texts[i] = c:within(g.condition, function() return read_condition(c, tree, depth + 1, kind) end) or ""
  end
  if #texts < children then c:fail("There are fewer conditions than stand in others") end
  local text = table.concat(texts, kind == 0 and " and " or " or ")
  return kind == 1 and outer == 0 and "(" .. text .. ")" or text
end

local function read_conditions(c, asked, set, type)
  local begin, tree = c.at, { left = c:several(), set = set, type = type }
  if tree.left == 0 or tree.left > conditions_max then c:fail("There are 1 to " .. conditions_max .. " conditions") end
  local text = c:within(g.condition, function() return read_condition(c, tree, 1) end)
  if tree.left > 0 then c:fail("Conditions stand beside each other without a word between them") end
  asked.conditions, asked.conditions_raw = text or "", c:raw_from(begin)
end

-- Reads the mask of a selection. Bit b of byte i is leaf 8 i + b.
local function read_selection_mask(c)
  local at, set = c.at, {}
  local count = c:several()
  for i = 0, count - 1 do
    local byte = c:byte()
    for bit = 0, 7 do
      if has(byte, 2 ^ bit) then set[8 * i + bit] = true end
    end
    if i == count - 1 and byte == 0 then c:fail("The last byte of a mask is not 0") end
  end
  if not c.failed then c.tree:add(g.leaves, c.buffer(at, c.at - at), runs_text(set, 0, 8 * count)) end
  return set
end

-- Reads a selection as bytes (sft/selection.h): the parts of fields and the conditions that a subscriber asks for.
local function read_selection(c, asked, type)
  local follows = c:byte()
  if follows > 0x07 then c:fail("A selection says what is unknown") end
  local set = read_selection_mask(c)
  if has(follows, 0x01) and not c.failed then read_parts(c, asked, set, type) end
  if has(follows, 0x02) and not c.failed then read_conditions(c, asked, set, type) end
  if has(follows, 0x04) and not c.failed then
    local at, us = c.at, c:leb_of_32_bits()
    if us == 0 then c:fail("A rate of 0 is not written") end
    if not c.failed then c.tree:add(g.rate, c.buffer(at, c.at - at), rate_text(us)) end
  end
  if c:left() > 0 then c:fail("A selection is longer than what it says") end
end

local function read_wants(c, asked, type)
  local bytes = c:count(1)
  if bytes == 0 then return end
  c:within(g.wants, function()
    local range = c:take(bytes)
    local inner = Cursor.new(range:tvb(), c.tree, c.expert_info)
    read_selection(inner, asked, type)
    asked.is_malformed = inner.failed
  end)
end

-- Returns a request as text, with its conditions and its rate.
local function asked_text(asked, type)
  local gate = asked.conditions .. (asked.conditions ~= "" and asked.rate ~= "" and " " or "") .. asked.rate
  return fields_text(asked, type) .. (gate ~= "" and " @ " .. gate or "")
end

-- Notes the number that stands for a request in datagrams. If several requests have the same number, the first one
-- whose type is known counts, or else the first one.
local function note(asked, type, topic, frame)
  local is_mask = asked.parts_raw == "" and asked.conditions_raw == ""
  local kind = "hash of a selection with " .. (asked.parts_raw ~= "" and "parts" or "conditions")
  if asked.parts_raw ~= "" and asked.conditions_raw ~= "" then kind = kind .. " and conditions" end
  if is_mask then kind = #asked.words > 1 and "hash of a mask" or "leaves" end
  local request = {
    kind = kind, frame = frame, is_typed = type ~= nil,
    text = fields_text(asked, type) .. (asked.conditions ~= "" and " @ " .. asked.conditions or ""),
    leaves = is_mask and runs_text(asked.set, 0, 64 * #asked.words) or nil,
  }
  local mask = asked.name:tohex()
  for _, key in ipairs({ mask, (topic or "?") .. " " .. mask }) do
    local former = known.names[key]
    if not former or (type and not former.is_typed) then known.names[key] = request end
  end
end

-- Reads a request. Returns its text; nil if it is malformed or has no subscriber.
local function read_request(c, pinfo)
  local asked = { set = {}, words = {}, parts = {}, parts_raw = "", conditions = "", conditions_raw = "", rate = "" }
  local reader = c:number(g.reader, 8)
  c:number(g.request_sequence, 8)
  for i = 1, c:count(8) do
    local word, item = c:number(g.mask_word, 8)
    if word == nil then return nil end
    asked.words[i] = word
    add_leaves(asked.set, word, 64 * (i - 1))
    item:append_text(" (leaves " .. leaves_text(word, 64 * (i - 1)) .. ")")
  end
  local type = reader and known.types[reader:tohex()]
  local period = c:number(g.period, 4)
  if period and period > 0 then asked.rate = rate_text(period) end
  read_wants(c, asked, type)
  c:ids(g.listening)
  c:ids(g.attached)
  c:ids(g.begun)
  if c.failed or asked.is_malformed then return nil end
  if reader == UInt64(0) then
    c:fail("A request of no subscriber")
    return nil
  end
  asked.name = name_of(asked)
  local text = asked_text(asked, type)
  c.tree:add(g.selection, text):set_generated()
  c.tree:add(g.name, asked.name):set_generated()
  note(asked, type, known.topics[reader:tohex()], pinfo.number)
  return "subscriber asks for " .. text
end

-- Reads a type description, and notes the type of the endpoint, since requests and datagrams name leaves by number.
local function read_type(c, id, role)
  local bytes = c:count(1)
  local range = bytes > 0 and c:take(bytes)
  if not range then return end
  local item = c.tree:add(g.description, range)
  local type = read_description(Cursor.new(range:tvb(), item, c.expert_info))
  if type == nil then return end
  item:append_text(string.format(" (%d leaves)", type.leaves))
  known.types[id:tohex()] = type
  if role ~= 0 then return end
  local former = known.leaves[id:lower()]
  known.leaves[id:lower()] = (former == nil or former == type.leaves) and type.leaves
end

-- Reads an address of an endpoint. An IPv4 address has the form ::ffff:a.b.c.d.
local function read_endpoint_address(c)
  local range = c:take(16)
  if range == nil then return nil end
  local is_ipv4 = range(0, 8):le_uint64() == UInt64(0) and range(8, 4):uint() == 0xffff
  if is_ipv4 then c.tree:add(g.ipv4, range(12, 4)) else c.tree:add(g.ipv6, range) end
  local port = c:number(g.port, 2)
  c:number(g.receive_buffer, 4)
  c:number(g.wireless, 1)
  if c.failed then return nil end
  local address = tostring(is_ipv4 and range(12, 4):ipv4() or range:ipv6())
  return string.format(is_ipv4 and "Address: %s:%d" or "Address: [%s]:%d", address, port)
end

-- Reads the host, the addresses and the doorbell at which an endpoint can be reached.
local function read_places(c)
  local host = c:take(32)
  if host then c.tree:add(g.host, host) end
  c:text(g.memory_failure)
  c:number(g.network, 8)
  c:number(g.may_use_shm, 1)
  c:number(g.may_use_udp, 1)
  for _ = 1, c:count(23) do
    if c.failed then return end
    c:within(g.address, function() return read_endpoint_address(c) end)
  end
  c:number(g.doorbell_page, 8)
  c:number(g.doorbell_slot, 4)
end

local function read_qos(c)
  c:number(g.reliability, 1)
  c:number(g.durability, 1)
  c:number(g.liveliness, 1)
  c:number(g.deadline, 8)
  c:number(g.liveliness_lease, 8)
  c:number(g.lifespan, 8)
  c:number(g.history_depth, 4)
end

-- Reads the announcement of a publisher or a subscriber. Returns its text.
local function read_endpoint(c)
  local id = c:number(g.id, 8)
  local role = c:number(g.role, 1)
  c:number(g.node, 8)
  c:text(g.node_name)
  local topic = c:text(g.topic)
  c:text(g.given_topic)
  local type_name = c:text(g.type_name)
  c:number(g.type_hash, 8)
  if c.failed then return nil end
  if id == UInt64(0) or roles[role] == nil then
    c:fail("An endpoint without id or role")
    return nil
  end
  known.topics[id:tohex()] = topic
  if role == 0 then
    local former = known.writers[id:lower()]
    known.writers[id:lower()] = (former == nil or former == topic) and topic
  end
  read_type(c, id, role)
  read_places(c)
  c:number(g.max_sample, 8)
  c:number(g.waits, 1)
  read_qos(c)
  return not c.failed and string.format("%s of %s, %s", roles[role], topic, type_name) or nil
end

local function read_inquiry(c)
  local topic = c:text(g.topic)
  local wants_accounts = c:number(g.wants_accounts, 1)
  local of = topic == "" and "all topics" or topic
  return "asks for the " .. (wants_accounts == 1 and "accounts" or "progress") .. " of " .. of
end

-- Functions that read the bodies of records, by their kinds.
local bodies = { [0] = read_endpoint, [1] = read_request, [2] = read_inquiry }

local head_bytes = 36  -- the bytes of a record before its body

-- Reads the members of a record before its body. Returns the kind of the record; nil if the sample has only the key.
local function read_head(c)
  local participant = c:take(16)
  if participant then c.tree:add(g.participant, participant) end
  c:number(g.slot, 4)
  local kind = c:number(g.kind, 1)
  if c.buffer:len() < head_bytes then return nil end
  local version = c:number(g.version, 1)
  if version ~= control_version then c:fail("The version is not " .. control_version) end
  if bodies[kind] == nil then c:fail("A record of an unknown kind") end
  c:take(2)  -- padding
  c:number(g.revision, 8)
  return kind
end

-- Reads a control sample. Returns its text.
local function read_record(c, pinfo)
  local kind = read_head(c)
  if kind == nil or c.failed then return nil end
  local bytes = c:count(1)
  if c.failed then return nil end
  if bytes == 0 then return kinds_of_records[kind] .. " withdrawn" end
  local _, text = c:within(g.body, function()
    local inner = Cursor.new(c:take(bytes):tvb(), c.tree, c.expert_info)
    local text = bodies[kind](inner, pinfo)
    if text and inner:left() > 0 then inner:fail("The body is longer than what it says") end
    c.failed = inner.failed
    return nil, text
  end)
  if c:left() > 3 then c:fail("The sample is longer than what it says") end
  return text
end

local function read_control(buffer, pinfo, root)
  local tree = root:add(control, buffer())
  local c = Cursor.new(buffer, tree, control_malformed)
  local is_key = buffer:len() < head_bytes
  local text = read_record(c, pinfo)
  if is_key and not c.failed then
    tree:append_text(": the key of a record")
    return
  end
  if text == nil or c.failed then text = "malformed" end
  tree:append_text(": " .. text)
  pinfo.cols.info:append(" [" .. text .. "]")
end

-- Returns true if bytes of an unknown topic are a record: kind and version are right, and the length of the body fits.
local function looks_like_control(buffer)
  if buffer:len() < head_bytes then return false end
  if buffer(20, 1):uint() > 2 or buffer(21, 1):uint() ~= control_version then return false end
  local behind = buffer:len() - head_bytes - buffer(32, 4):le_uint()
  return buffer(22, 2):uint() == 0 and behind >= 0 and behind <= 3
end

-- Registers the dissectors with Wireshark's dissector of RTPS, which passes on the contents of a sample if the type of
-- the topic was announced in the capture. It writes the name of the type in lower case, with underscores. In a capture
-- that began later, samples that look like control samples are dissected after everything else.
local function join_rtps()
  local submessage_bytes = Field.new("rtps.sm.octetsToNextHeader")
  local encapsulation = Field.new("rtps.param.serialize.encap_kind")
  local undissected = Field.new("rtps.issueData")
  local bytes_of_fragmented = Field.new("rtps.data_frag.sample_size")

  -- Returns the number of bytes that belong to the sample. Wireshark passes on all bytes up to the end of the datagram.
  local function sample_bytes(buffer)
    local all, at = { submessage_bytes() }, buffer:offset()
    local last = all[#all]
    if last == nil or last.value == 0 or last.offset > at then return buffer:len() end
    return math.min(buffer:len(), last.offset + 2 + last.value - at)
  end

  function control.dissector(buffer, pinfo, root)
    local all = { encapsulation() }
    local bytes = sample_bytes(buffer)
    if bytes <= 0 or (#all > 0 and all[#all].value ~= 1) then return 0 end
    read_control(buffer(0, bytes):tvb(), pinfo, root)
    return bytes
  end

  -- Returns true if the bytes from offset `at` on are a fragment. Then the header of their submessage has the size of
  -- the whole sample.
  local function is_fragment(at)
    local begin = 0
    for _, bytes in ipairs({ submessage_bytes() }) do
      if bytes.offset < at then begin = math.max(begin, bytes.offset) end
    end
    for _, bytes in ipairs({ bytes_of_fragmented() }) do
      if bytes.offset > begin and bytes.offset < at then return true end
    end
    return false
  end

  local unannounced = Proto("sft_control_unannounced", "SFT control samples of topics that were announced earlier")
  function unannounced.dissector(_, pinfo, root)
    for _, bytes in ipairs({ undissected() }) do
      local buffer = bytes.range and bytes.range:tvb()
      if buffer and looks_like_control(buffer) and not is_fragment(bytes.offset) then
        read_control(buffer, pinfo, root)
      end
    end
  end
  register_postdissector(unannounced)

  local types = DissectorTable.get("rtps.type_name")
  types:add("sft_control_record", control)
  types:add("sft_control_heartbeatsample", heartbeat)
end

-- If Wireshark has no dissector of RTPS, datagrams are still shown.
if not pcall(join_rtps) then print("SFT: this Wireshark does not let control samples be dissected") end
