// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/bag_file.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <utility>

#include <bzlib.h>
#include <lz4frame.h>

namespace plumbline {
namespace {

constexpr std::string_view kBagMagic = "#ROSBAG V2.0\n";
/// A chunk is 768 kB by default, or a message if that is longer.
constexpr std::uint32_t kLargestChunk = 256u << 20;
constexpr std::uint32_t kLargestBagHeader = 1u << 20;

enum BagOp : std::uint8_t {
  kMessageData = 2,
  kBagHeader = 3,
  kIndexData = 4,
  kChunkRecord = 5,
  kChunkInfo = 6,
  kConnection = 7
};

template <typename Number>
Number LittleEndian(const char* bytes) {
  Number number;
  std::memcpy(&number, bytes, sizeof number);  // as all machines that this builds for
  return number;
}

using BagFields = std::map<std::string, std::string_view, std::less<>>;

/// The fields NAME=VALUE of a header, or what is wrong with them.
std::optional<BagFields> FieldsOf(std::string_view header) {
  BagFields fields;
  while (!header.empty()) {
    if (header.size() < 4) return std::nullopt;
    const auto length = LittleEndian<std::uint32_t>(header.data());
    header.remove_prefix(4);
    if (length > header.size()) return std::nullopt;
    const std::string_view field = header.substr(0, length);
    const std::size_t equals = field.find('=');
    if (equals == std::string_view::npos) return std::nullopt;
    fields[std::string(field.substr(0, equals))] = field.substr(equals + 1);
    header.remove_prefix(length);
  }
  return fields;
}

template <typename Number>
std::optional<Number> NumberField(const BagFields& fields, std::string_view name) {
  const auto field = fields.find(name);
  if (field == fields.end() || field->second.size() != sizeof(Number)) return std::nullopt;
  return LittleEndian<Number>(field->second.data());
}

std::string TextField(const BagFields& fields, std::string_view name) {
  const auto field = fields.find(name);
  return field == fields.end() ? std::string() : std::string(field->second);
}

/// Seconds and nanoseconds, four bytes each.
std::int64_t BagStamp(const char* bytes) {
  return std::int64_t{LittleEndian<std::uint32_t>(bytes)} * 1'000'000'000 +
         LittleEndian<std::uint32_t>(bytes + 4);
}

/// Grows with what comes out, so that a wrong size asks for no memory.
std::optional<std::string> UnpackBz2(std::string packed, std::size_t size) {
  bz_stream stream = {};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return std::nullopt;
  stream.next_in = packed.data();
  stream.avail_in = static_cast<unsigned>(packed.size());
  std::string unpacked;
  int state = BZ_OK;
  while (state == BZ_OK && unpacked.size() <= size) {
    const std::size_t before = unpacked.size();
    unpacked.resize(std::min(size + 1, std::max<std::size_t>(1 << 20, 2 * before)));
    stream.next_out = unpacked.data() + before;
    stream.avail_out = static_cast<unsigned>(unpacked.size() - before);
    const unsigned left = stream.avail_in;
    state = BZ2_bzDecompress(&stream);
    const bool stuck = stream.avail_in == left && stream.avail_out == unpacked.size() - before;
    unpacked.resize(unpacked.size() - stream.avail_out);
    if (stuck) break;
  }
  BZ2_bzDecompressEnd(&stream);
  if (state != BZ_STREAM_END || unpacked.size() != size) return std::nullopt;
  return unpacked;
}

std::optional<std::string> UnpackLz4(const std::string& packed, std::size_t size) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) return std::nullopt;
  std::string unpacked;
  std::size_t read = 0, hint = 1;
  while (hint != 0 && unpacked.size() <= size) {
    const std::size_t before = unpacked.size();
    unpacked.resize(std::min(size + 1, std::max<std::size_t>(1 << 20, 2 * before)));
    std::size_t out = unpacked.size() - before, in = packed.size() - read;
    hint = LZ4F_decompress(context, unpacked.data() + before, &out, packed.data() + read, &in,
                           nullptr);
    unpacked.resize(before + out);
    read += in;
    if (LZ4F_isError(hint) || (in == 0 && out == 0)) break;
  }
  LZ4F_freeDecompressionContext(context);
  if (hint != 0 || unpacked.size() != size) return std::nullopt;
  return unpacked;
}

}  // namespace

struct BagFile::Record {
  std::string header;
  std::uint64_t data_begin = 0;
  std::uint32_t data_size = 0;
  std::uint64_t end() const { return data_begin + data_size; }
};

Result<BagFile::Record> BagFile::ReadRecord(std::uint64_t begin) const {
  const Result<std::string> length = file_.Read(begin, 4);
  if (!length.ok()) return length.error();
  const auto header_size = LittleEndian<std::uint32_t>(length->data());
  if (header_size > kLargestBagHeader) return file_.Damage("a header of more than 1 MB");
  Result<std::string> header = file_.Read(begin + 4, std::uint64_t{header_size} + 4);
  if (!header.ok()) return header.error();
  Record record;
  record.data_size = LittleEndian<std::uint32_t>(header->data() + header_size);
  record.data_begin = begin + 8 + header_size;
  record.header = std::move(*header);
  record.header.resize(header_size);
  if (record.end() > file_.size()) return file_.Damage("it ends before what it says to hold");
  return record;
}

Status BagFile::AddTopic(std::uint32_t connection, const std::string& name,
                         std::string_view header) {
  const std::optional<BagFields> fields = FieldsOf(header);
  if (!fields) return file_.Damage("a connection whose header is none");
  if (std::find(connections_.begin(), connections_.end(), connection) != connections_.end())
    return {};
  connections_.push_back(connection);
  topics_.push_back({name, TextField(*fields, "type")});
  return {};
}

Status BagFile::ReadChunk(std::uint64_t begin) {
  const Result<Record> record = ReadRecord(begin);
  if (!record.ok()) return record.error();
  const std::optional<BagFields> fields = FieldsOf(record->header);
  if (!fields || NumberField<std::uint8_t>(*fields, "op") != kChunkRecord)
    return file_.Damage("no chunk where the index has one");
  Chunk chunk{record->data_begin, record->data_size,
              NumberField<std::uint32_t>(*fields, "size").value_or(0),
              TextField(*fields, "compression")};
  if (chunk.compression != "none" && chunk.compression != "bz2" && chunk.compression != "lz4") {
    return Error{ErrorCode::kUnsupported, "the bag '" + file_.path().string() +
                                              "' is compressed by '" + chunk.compression +
                                              "'; this version reads none, bz2 and lz4"};
  }
  if (chunk.size > kLargestChunk ||
      (chunk.compression == "none" && chunk.size != chunk.packed_size))
    return file_.Damage("a chunk whose size cannot be right");
  const std::size_t index = chunks_.size();
  chunks_.push_back(chunk);
  // What the chunk holds is told behind it, connection by connection.
  for (std::uint64_t at = record->end(); at < file_.size();) {
    const Result<Record> entries = ReadRecord(at);
    if (!entries.ok()) return entries.error();
    const std::optional<BagFields> of = FieldsOf(entries->header);
    if (!of || NumberField<std::uint8_t>(*of, "op") != kIndexData) break;
    const auto connection = NumberField<std::uint32_t>(*of, "conn");
    const auto count = NumberField<std::uint32_t>(*of, "count");
    const auto topic = std::find(connections_.begin(), connections_.end(), connection.value_or(0));
    if (!connection || !count || topic == connections_.end() ||
        std::uint64_t{*count} * 12 != entries->data_size)
      return file_.Damage("an index that does not fit");
    const Result<std::string> data = file_.Read(entries->data_begin, entries->data_size);
    if (!data.ok()) return data.error();
    for (std::size_t i = 0; i < *count; ++i) {
      messages_.push_back({static_cast<std::size_t>(topic - connections_.begin()),
                           BagStamp(data->data() + 12 * i), index,
                           LittleEndian<std::uint32_t>(data->data() + 12 * i + 8)});
    }
    at = entries->end();
  }
  return {};
}

Status BagFile::ReadIndex() {
  const Result<std::string> magic = file_.Read(0, kBagMagic.size());
  if (!magic.ok() || !magic->starts_with("#ROSBAG V")) {
    return Error{ErrorCode::kCorrupt, "'" + file_.path().string() + "' is not a ROS bag"};
  }
  if (*magic != kBagMagic) {
    return Error{ErrorCode::kUnsupported,
                 "the bag '" + file_.path().string() + "' is of version '" + magic->substr(8, 4) +
                     "'; this version reads 2.0 (rosbag fix or reindex makes one)"};
  }
  const Result<Record> head = ReadRecord(kBagMagic.size());
  if (!head.ok()) return head.error();
  const std::optional<BagFields> fields = FieldsOf(head->header);
  const auto index = fields ? NumberField<std::uint64_t>(*fields, "index_pos") : std::nullopt;
  if (!index || NumberField<std::uint8_t>(*fields, "op") != kBagHeader)
    return file_.Damage("its header is none");
  if (!TextField(*fields, "encryptor").empty())
    return Error{ErrorCode::kUnsupported, "the bag '" + file_.path().string() + "' is encrypted"};
  if (*index == 0 || *index > file_.size()) {
    return Error{ErrorCode::kInvalidInput,
                 "the bag '" + file_.path().string() +
                     "' has no index, as one that was not closed or was cut off; make one with "
                     "rosbag reindex"};
  }
  std::vector<std::uint64_t> chunks;
  for (std::uint64_t at = *index; at < file_.size();) {
    const Result<Record> record = ReadRecord(at);
    if (!record.ok()) return record.error();
    const std::optional<BagFields> of = FieldsOf(record->header);
    if (!of) return file_.Damage("a header of its index is none");
    const auto op = NumberField<std::uint8_t>(*of, "op").value_or(0);
    if (op == kConnection) {
      const auto connection = NumberField<std::uint32_t>(*of, "conn");
      if (!connection) return file_.Damage("a connection without a number");
      const Result<std::string> data = file_.Read(record->data_begin, record->data_size);
      if (!data.ok()) return data.error();
      if (Status added = AddTopic(*connection, TextField(*of, "topic"), *data); !added.ok())
        return added;
    } else if (op == kChunkInfo) {
      const auto place = NumberField<std::uint64_t>(*of, "chunk_pos");
      if (!place || *place < kBagMagic.size()) return file_.Damage("a chunk without a place");
      chunks.push_back(*place);
    }
    at = record->end();
  }
  for (const std::uint64_t chunk : chunks) {
    if (Status read = ReadChunk(chunk); !read.ok()) return read;
  }
  std::stable_sort(
      messages_.begin(), messages_.end(),
      [](const BagMessage& a, const BagMessage& b) { return a.stamp_ns < b.stamp_ns; });
  return {};
}

Result<std::shared_ptr<const BagFile>> BagFile::Open(const std::filesystem::path& file) {
  Result<RandomAccessFile> opened = RandomAccessFile::Open(file);
  if (!opened.ok()) return opened.error();
  std::shared_ptr<BagFile> bag(new BagFile(std::move(opened).value()));
  if (Status read = bag->ReadIndex(); !read.ok()) return read.error();
  return std::shared_ptr<const BagFile>(std::move(bag));
}

Result<std::shared_ptr<const std::string>> BagFile::Unpacked(std::size_t index) const {
  const std::lock_guard lock(mutex_);
  if (unpacked_chunk_ == index) return unpacked_;
  const Chunk& chunk = chunks_[index];
  Result<std::string> packed = file_.Read(chunk.data_begin, chunk.packed_size);
  if (!packed.ok()) return packed.error();
  std::optional<std::string> unpacked = chunk.compression == "bz2"
                                            ? UnpackBz2(std::move(*packed), chunk.size)
                                            : UnpackLz4(*packed, chunk.size);
  if (!unpacked) return file_.Damage("a chunk that cannot be unpacked");
  unpacked_ = std::make_shared<const std::string>(std::move(*unpacked));
  unpacked_chunk_ = index;
  return unpacked_;
}

Result<std::string> BagFile::Read(const BagMessage& message, std::size_t enough) const {
  const Chunk& chunk = chunks_[message.chunk];
  if (chunk.compression == "none") {
    if (message.offset > chunk.size) return file_.Damage("a message beyond its chunk");
    const Result<Record> record = ReadRecord(chunk.data_begin + message.offset);
    if (!record.ok()) return record.error();
    if (record->end() > chunk.data_begin + chunk.size)
      return file_.Damage("a message beyond its chunk");
    const std::optional<BagFields> fields = FieldsOf(record->header);
    if (!fields || NumberField<std::uint8_t>(*fields, "op") != kMessageData)
      return file_.Damage("no message where the index has one");
    return file_.Read(record->data_begin, std::min<std::uint64_t>(record->data_size, enough));
  }
  const Result<std::shared_ptr<const std::string>> unpacked = Unpacked(message.chunk);
  if (!unpacked.ok()) return unpacked.error();
  std::string_view rest = **unpacked;
  const auto take = [&rest](std::size_t count) -> std::optional<std::string_view> {
    if (count > rest.size()) return std::nullopt;
    const std::string_view taken = rest.substr(0, count);
    rest.remove_prefix(count);
    return taken;
  };
  if (!take(message.offset)) return file_.Damage("a message beyond its chunk");
  const auto sized = [&]() -> std::optional<std::string_view> {
    const auto length = take(4);
    return length ? take(LittleEndian<std::uint32_t>(length->data())) : std::nullopt;
  };
  const auto header = sized();
  const auto fields = header ? FieldsOf(*header) : std::nullopt;
  if (!fields || NumberField<std::uint8_t>(*fields, "op") != kMessageData)
    return file_.Damage("no message where the index has one");
  const auto data = sized();
  if (!data) return file_.Damage("a message beyond its chunk");
  return std::string(data->substr(0, enough));
}

}  // namespace plumbline
