-- SFT in Wireshark: a dissector for its datagrams (udp_transport/wire/wire_format.md).
--
-- Copy this file into the folder "Personal Lua Plugins" (Help, About Wireshark, Folders), or try it with
-- `tshark -X lua_script:sft.lua -r capture.pcap`. The dissector recognises datagrams by their contents, whatever their
-- ports. With "Decode As...", Wireshark takes all datagrams of a port for SFT, and reports what is wrong with others.
--
-- A new kind of datagram needs an entry in `kinds`, and a new flag an entry in `flags`.

local sft = Proto("sft", "Selective Field Transmission")

local wire_version = 1
local common_bytes = 16

local f = {
  version = ProtoField.uint8("sft.version", "Version", base.DEC, nil, 0xf0),
  kind = ProtoField.uint8("sft.kind", "Kind", base.DEC, nil, 0x0f),
  flags = ProtoField.uint8("sft.flags", "Flags", base.HEX),
  variant = ProtoField.uint16("sft.variant", "Variant"),
  writer = ProtoField.uint32("sft.writer", "Writer", base.HEX),
  sequence = ProtoField.uint32("sft.sequence", "Sequence (low half)"),
  total = ProtoField.uint32("sft.total", "Bytes of the body"),
  mask = ProtoField.uint64("sft.mask", "Mask", base.HEX),
  leaves = ProtoField.string("sft.leaves", "Leaves if whole fields were asked for"),
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

-- The bits of a word of the mask as text, "0-3, 7". `first` is the number of the word's lowest bit.
local function leaves_text(word, first)
  local runs, begin = {}, nil
  local bits = { word:lower(), word:higher() }
  for leaf = 0, 64 do
    local set = leaf < 64 and has(bits[leaf < 32 and 1 or 2], 2 ^ (leaf % 32))
    if set and begin == nil then begin = leaf end
    if not set and begin ~= nil then
      local last = leaf - 1
      runs[#runs + 1] = begin == last and tostring(first + begin) or (first + begin) .. "-" .. (first + last)
      begin = nil
    end
  end
  return #runs == 0 and "none" or table.concat(runs, ", ")
end

-- A position in the datagram, which advances with each read. A read beyond the end returns nil, and is reported once.
local Cursor = {}
Cursor.__index = Cursor

function Cursor.new(buffer, tree) return setmetatable({ buffer = buffer, at = 0, tree = tree }, Cursor) end
function Cursor:left() return self.buffer:len() - self.at end
function Cursor:fail(what)
  if not self.failed then self.tree:add_proto_expert_info(malformed, what) end
  self.failed = true
end
function Cursor:take(bytes)
  if self.failed then return nil end
  if bytes > self:left() then
    self:fail("The datagram ends " .. (bytes - self:left()) .. " bytes too early")
    return nil
  end
  local range = self.buffer(self.at, bytes)
  self.at = self.at + bytes
  return range
end
-- Reads a number into a field. Returns it and its item.
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

-- Reads the mark of a sample that is sent to a group. Only a rate may stand beside it: a group has no late readers, and
-- each member knows the sample's position in its channel.
local function read_group_mark(c, set)
  if has(set, 0x04) or has(set, 0x08) then c:fail("Only a rate may stand beside a position in a group") end
  local group = c:number(f.group, 4)
  c:number(f.sequence_high, 4)
  local ordinal = c:number(f.group_ordinal, 8)
  if ordinal == UInt64(0) then c:fail("Ordinals count from 1") end
  return { group = group, group_ordinal = ordinal }
end

-- Reads the marks behind a header, as its flags say, but not the words of the mask.
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

-- Reads the words of a mask. The datagram does not contain the number of leaves of the type, so that only the length of
-- a complete body tells where the words end.
local function read_mask_words(c, body_bytes)
  local words = math.floor((c:left() - body_bytes) / 8)
  for i = 0, words - 1 do
    local word, item = c:number(f.mask_word, 8)
    if word ~= nil then item:append_text(" (leaves " .. leaves_text(word, 64 * i) .. ")") end
  end
end

-- Tells whether the sample passed a gate that has conditions and no period. `c` stands behind the mask.
local function has_conditions(c, set)
  local rate_follows = has(set, 0x02) and c:left() >= 12
  return rate_follows and c.buffer(c.at + 8, 4):le_uint() == 0
end

-- The datagram does not say whether a mask without words is the hash of a selection. It is one if the reader asked for
-- conditions or for parts of fields.
local function read_mask(c, set)
  local mask, item = c:number(f.mask, 8)
  if mask == nil then return end
  if has(set, 0x01) then
    item:append_text(" (hash)")
  elseif has_conditions(c, set) then
    item:append_text(" (hash of a selection)")
  else
    item:append_text(" (hash of a selection if parts of fields were asked for)")
    c.tree:add(f.leaves, c.buffer(c.at - 8, 8), leaves_text(mask, 0))
  end
end

local function place_text(place)
  if place.group_ordinal then
    return string.format(" group=%u ordinal=%s", place.group, tostring(place.group_ordinal))
  end
  return place.ordinal and " ordinal=" .. tostring(place.ordinal) or ""
end

local function read_first(c, set)
  local sequence = c:number(f.sequence, 4)
  local total = c:number(f.total, 4)
  read_mask(c, set)
  c:stamp(f.stamp)
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
  local set = (has(bits, 0x1) and 0x01 or 0) + (has(bits, 0x2) and 0x80 or 0)
  local item = c.tree:add(f.flags, range, set)
  for _, flag in ipairs(flags) do item:add(flag.field, range, set) end
  c.tree:add(f.variant, range, math.floor(bits / 4) % 2048)
  c.tree:add(f.channel, range, math.floor(bits / 8192)):append_text(" (the low 11 bits of its number)")
  return set
end

local function read_whole(c, set)
  local sequence = c:number(f.sequence, 4)
  local ordinal = c:number(f.ordinal, 4)
  if ordinal == 0 then c:fail("Ordinals count from 1") end
  read_mask(c, set)
  c:stamp(f.stamp)
  if c.failed then return "" end
  local bytes = c:left()
  if has(set, 0x01) then
    c:rest(f.payload)  -- only the type tells where the words end
    return string.format("seq=%u ordinal=%u", sequence, ordinal)
  end
  c.tree:add(f.total, bytes):set_generated()
  c:rest(f.payload)
  return string.format("seq=%u %u bytes ordinal=%u", sequence, bytes, ordinal)
end

local function read_following(c)
  local sequence = c:number(f.sequence, 4)
  local offset = c:number(f.offset, 4)
  if not c.failed and c:left() == 0 then c:fail("A following datagram has at least one byte of payload") end
  if c.failed then return "" end
  local bytes = c:left()
  c:rest(f.payload)
  return string.format("seq=%u bytes %u to %.0f", sequence, offset, offset + bytes)
end

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

-- Reads the bodies of packed samples: `each` bytes long, or with a length in front of each if `each` is 0.
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

local function read_packed(c, set)
  local sequence = c:number(f.sequence, 4)
  local samples = c:number(f.samples, 2)
  local each = c:number(f.bytes_each, 2)
  read_mask(c, set)
  c:stamp(f.stamp)
  local place = read_marks(c, set)
  if c.failed then return "" end
  local lengths = has(set, 0x10)
  if samples == 0 or samples > 256 then c:fail("A packed datagram has 1 to 256 samples") end
  if lengths ~= (each == 0) then c:fail("All samples have the same length, or lengths follow; not both") end
  if has(set, 0x01) and not lengths then read_mask_words(c, samples * each) end
  if has(set, 0x01) and lengths then
    c:rest(f.payload)  -- only the type tells where the words end
  else
    read_samples(c, sequence, place, samples, each)
  end
  if c.failed then return "" end
  if c:left() > 0 and not lengths then c:fail("The datagram is longer than its number of samples") end
  c:rest(f.padding)
  return string.format("seq=%u and %u more", sequence, samples - 1) .. place_text(place)
end

-- Reads a mark, or a report, which repeats most of a mark.
local function read_flow(c, report)
  local position = c:number(f.position, 8)
  local window = c:number(report and f.window or f.reserved, 4)
  c:number(f.datagrams, 4)
  c:number(report and f.came or f.reserved, 4)
  c:number(f.reserved, 4)
  c:number(f.sent_at, 8)
  if c.failed then return "" end
  if c:left() > 0 then c:fail("Marks and reports have 40 bytes") end
  return "position=" .. tostring(position) .. (report and string.format(" window=%u", window) or "")
end
local function read_mark(c) return read_flow(c, false) end
local function read_report(c) return read_flow(c, true) end

-- Reads an address. Like all numbers, it has its lowest byte first.
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

-- The kinds of datagrams by number: the field at offset 2 (or the function that reads the 3 bytes at offset 1), the
-- field at offset 4 if it is not the writer, the flags that may be set, the least number of bytes, and the function
-- that reads the rest.
local kinds = {
  [1] = { name = "first", at_2 = f.variant, flags = 0xcf, bytes = 32, read = read_first },
  [2] = { name = "following", at_2 = f.variant, flags = 0, bytes = 17, read = read_following },
  [3] = { name = "heartbeat", at_2 = f.port, flags = 0, bytes = 32, read = read_heartbeat },
  [4] = { name = "ack", at_2 = f.parts, flags = 0, bytes = 24, read = read_ack },
  [5] = { name = "packed", at_2 = f.variant, flags = 0x19, bytes = 33, read = read_packed },
  [6] = { name = "group offer", at_2 = f.group_port, flags = 0, bytes = 32, read = read_group_offer },
  [7] = { name = "group report", at_2 = f.reserved_short, flags = 0, bytes = 24, read = read_group_report },
  [8] = { name = "mark", at_2 = f.port, at_4 = f.flow, flags = 0, bytes = 40, read = read_mark },
  [9] = { name = "report", at_2 = f.reserved_short, at_4 = f.flow, flags = 0, bytes = 40, read = read_report },
  [10] = { name = "whole", from_1 = read_short_place, flags = 0xff, bytes = 32, read = read_whole },
  [11] = { name = "group probe", at_2 = f.reserved_short, flags = 0, bytes = 24, read = read_group_probe },
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
  local what = kind.read(c, set, at_2)
  local text = string.format("%s %s=%08x %s", kind.name, kind.at_4 and "flow" or "writer", writer, what)
  if c.failed then text = text .. " [malformed]" end
  pinfo.cols.info = text
  tree:append_text(": " .. text)
  return buffer:len()
end

-- True if a first datagram may have these flags and this length.
local function plausible_flags(set, bytes)
  if has(set, 0x40) then return bytes >= 48 and not (has(set, 0x04) or has(set, 0x08)) end
  return bytes >= 48 or not has(set, 0x08)
end
-- True if a whole datagram has an ordinal, and a stamp from 1970 to 2100. Any flags are possible.
local function plausible_whole(buffer) return buffer(12, 4):le_uint() ~= 0 and buffer(28, 4):le_uint() < 0x39000000 end
local function plausible_address(address) return address == 0 or math.floor(address / 65536) == 0xefff end

-- True if a datagram whose first bytes look like SFT is plausible in the other bytes, too.
local function plausible(buffer, number)
  if number == 1 then return plausible_flags(buffer(1, 1):uint(), buffer:len()) end
  if number == 3 then return buffer:len() == 32 and buffer(12, 4):le_uint() == 0 end
  if number == 4 then return buffer:len() == 24 + 12 * buffer(2, 2):le_uint() end
  if number == 5 then return buffer(12, 2):le_uint() >= 1 and buffer(12, 2):le_uint() <= 256 end
  if number == 6 then return buffer:len() == 32 and plausible_address(buffer(16, 4):le_uint()) end
  if number == 7 then return buffer:len() == 24 end
  if number == 8 or number == 9 then return buffer:len() == 40 end
  if number == 10 then return plausible_whole(buffer) end
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
