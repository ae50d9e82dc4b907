#include "asset/nanovdb_layout.h"

#include <blosc.h>
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <string_view>

#include "asset/lazy_bytes.h"
#include "asset/printable.h"
#include <fumarole/asset/load_limits.h>
#include <fumarole/errors.h>

// A file is segments, one after another, each of
//
//   a header (magic, version, number of grids, codec), per grid metadata and name, per grid its
//   buffer, plain, or in chunks of zip or Blosc that each have their size before them.
//
// A buffer is what NanoVDB has in memory, little endian: GridData (672 bytes), TreeData (64), the
// root with its tiles, then nodes of 32^3, of 16^3 and leaves of 8^3, each found by the offset that
// its parent holds, and blind data, which is not read. Structures are aligned to 32 bytes.

namespace fumarole::asset {

static_assert(std::endian::native == std::endian::little, "a .nvdb is read as it lies in memory");

namespace nanovdb_file {  // apart from vdb_layout.cpp's, which has some of these names too

namespace {

constexpr std::string_view kMagic = "NanoVDB";  // then 0; since version 32.6 files have 2, grids 1
constexpr std::uint32_t kMajor = 32;

constexpr std::size_t kHeaderBytes = 16;
constexpr std::size_t kMetaBytes = 176;
constexpr std::size_t kGridBytes = 672;
constexpr std::size_t kTreeBytes = 64;
// In GridData.
constexpr std::size_t kGridCount = 28, kGridSize = 32, kGridName = 40, kGridNameBytes = 256,
                      kGridMatrix = 384, kGridOffset = 528, kGridClass = 632, kGridType = 636;
constexpr std::size_t kChunkBytes = std::size_t(1) << 30;  // of which Blosc packs one at a time
constexpr std::size_t kAlignment = 32;
constexpr std::size_t kLeafCount = 512;

enum class Codec : std::uint16_t { none, zip, blosc };

/// NanoVDB's numbers of the types of values, as far as they have names here.
constexpr std::array kTypeNames = {
    "unknown", "float", "double", "int16", "int32", "int64", "vec3s", "vec3d", "mask",  "half",
    "uint32",  "bool",  "rgba8",  "Fp4",   "Fp8",   "Fp16",  "FpN",   "vec4s", "vec4d", "index"};

template <class T> T at(const char* bytes, std::size_t offset)
{
    T value;
    std::memcpy(&value, bytes + offset, sizeof(T));
    return value;
}

constexpr std::size_t align(std::size_t bytes)
{
    return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

/// Where things stand in the nodes of one type of values [bytes].
struct NodeLayout {
    std::size_t value;            ///< bytes of a value
    std::size_t root_background;  ///< where the background stands in the root
    std::size_t root_size;        ///< without its tiles
    std::size_t tile_value;       ///< where the value stands in a tile of the root
    std::size_t tile_size;
    std::size_t stats;       ///< bytes of a node's minimum, maximum, average and deviation
    std::size_t entry;       ///< bytes of an entry of a node's table
    std::size_t leaf_codes;  ///< where a leaf's values begin
    std::size_t leaf_size;   ///< bytes of a leaf; of FpN of what all leaves have

    [[nodiscard]] std::size_t table(std::size_t mask_bytes) const
    {
        return align(32 + 2 * mask_bytes + stats);
    }
    [[nodiscard]] std::size_t node_size(std::size_t mask_bytes) const
    {
        return table(mask_bytes) + 8 * mask_bytes * entry;
    }
};

NodeLayout nodes_of(NanoValue type)
{
    NodeLayout at{};
    const bool wide = type == NanoValue::float64, vector = type == NanoValue::vec3f;
    const std::size_t number = wide ? 8 : 4;
    at.value = vector ? 3 * number : number;
    at.stats = 2 * at.value + 2 * number;
    at.root_background = wide ? 32 : 28;
    at.root_size = align(at.root_background + at.value + at.stats);
    at.tile_value = wide ? 24 : 20;
    at.tile_size = align(at.tile_value + at.value);
    at.entry = (at.value + 7) / 8 * 8;
    constexpr std::size_t kLeafHead = 16 + kLeafCount / 8;
    at.leaf_codes = align(kLeafHead + at.stats);
    at.leaf_size = at.leaf_codes + kLeafCount * at.value;
    switch (type) {
    case NanoValue::fp4:
        at.leaf_size = at.leaf_codes + kLeafCount / 2;
        break;
    case NanoValue::fp8:
        at.leaf_size = at.leaf_codes + kLeafCount;
        break;
    case NanoValue::fp16:
        at.leaf_size = at.leaf_codes + kLeafCount * 2;
        break;
    case NanoValue::fpn:
        at.leaf_size = at.leaf_codes;
        break;
    default:
        break;
    }
    return at;
}

/// Bits of a leaf's codes; 0: its values are plain.
unsigned code_bits(NanoValue type, const char* leaf)
{
    switch (type) {
    case NanoValue::fp4:
        return 4;
    case NanoValue::fp8:
        return 8;
    case NanoValue::fp16:
        return 16;
    case NanoValue::fpn:  // the power of two in the top of the flags
        return 1u << (std::uint8_t(leaf[15]) >> 5);
    default:
        return 0;
    }
}

/// code * quantum + minimum, in single precision as NanoVDB has it.
void decode(const char* leaf, std::size_t codes, unsigned bits, std::array<float, kLeafCount>& out)
{
    constexpr std::size_t kMinimum = 80, kQuantum = 84;
    const auto minimum = at<float>(leaf, kMinimum), quantum = at<float>(leaf, kQuantum);
    const unsigned per_word = 32 / bits;
    for (unsigned i = 0; i < kLeafCount; ++i) {
        const auto word = at<std::uint32_t>(leaf, codes + 4 * std::size_t(i / per_word));
        const std::uint32_t code = word >> (i % per_word * bits) & ((1u << bits) - 1);
        out[i] = float(code) * quantum + minimum;
    }
}

std::uint32_t crc(const char* bytes, std::size_t size)
{
    return std::uint32_t(crc32_z(0, reinterpret_cast<const Bytef*>(bytes), size));
}

/// Walks one buffer, of which nothing is believed: what does not fit is an Error.
class TreeWalk {
public:
    TreeWalk(const VdbLayout& layout, const VdbGridLayout& grid)
        : layout_(layout), grid_(grid), nano_(*grid.nano), nodes_(nodes_of(nano_.value)),
          bytes_((nano_.expanded ? nano_.expanded->data() : layout.bytes.get()) + nano_.begin)
    {
        check_head();
    }

    void run(NanoVisitor& visitor)
    {
        const std::size_t root = root_offset();
        visitor.background(bytes_ + root + nodes_.root_background);
        const auto tiles = at<std::uint32_t>(bytes_, root + kRootTiles);
        std::vector<std::uint64_t> keys;
        for (std::uint32_t i = 0; i < tiles; ++i) {
            const std::size_t tile = root + nodes_.root_size + i * nodes_.tile_size;
            const auto key = at<std::uint64_t>(bytes_, tile);
            keys.push_back(key);
            const glm::ivec3 origin = origin_of(key);
            if (const auto child = at<std::int64_t>(bytes_, tile + 8); child != 0)
                node(follow(root, child, 2), 5, origin, visitor);
            else
                visitor.tile(origin, 4096, bytes_ + tile + nodes_.tile_value,
                             at<std::uint32_t>(bytes_, tile + 16) != 0);
        }
        std::ranges::sort(keys);
        if (std::ranges::adjacent_find(keys) != keys.end())
            fail("two nodes in one place");
        for (std::size_t level = 0; level < 3; ++level)
            if (visited_[level].size() != counts_[level])
                fail(fmt::format("{} nodes of level {} where {} are said to be",
                                 visited_[level].size(), level, counts_[level]));
    }

    [[nodiscard]] std::uint64_t leaves() const { return counts_[0]; }
    [[nodiscard]] std::uint64_t expanded_bytes() const
    {
        constexpr std::size_t kLeafBytes = 128;  // that OpenVDB has in a leaf beside its values
        const std::size_t entry = std::max(nodes_.value, sizeof(void*));
        return counts_[0] * (kLeafCount * nodes_.value + kLeafBytes) +
               counts_[1] * (4096 * entry + 1024) + counts_[2] * (32768 * entry + 8192);
    }

    /// After run().
    void check_sums() const;

private:
    static constexpr std::size_t kRootTiles = 24;  ///< after the box of the active voxels

    /// Finds the root, and as many nodes as there may be.
    void check_head()
    {
        const std::size_t root = root_offset();
        const auto tiles = at<std::uint32_t>(bytes_, root + kRootTiles);
        if (tiles > (nano_.size - root - nodes_.root_size) / nodes_.tile_size)
            fail(fmt::format("a root of {} tiles", tiles));
        tiles_end_ = root + nodes_.root_size + tiles * nodes_.tile_size;
        for (std::size_t level = 0; level < 3; ++level) {
            counts_[level] = at<std::uint32_t>(bytes_, kGridBytes + 32 + 4 * level);
            if (counts_[level] > (nano_.size - tiles_end_) / size_of(level))
                fail(fmt::format("{} nodes of level {}", counts_[level], level));
        }
    }

    [[noreturn]] void fail(const std::string& what) const
    {
        throw Error(fmt::format("{}: damaged: grid '{}': {}", layout_.file.string(),
                                printable(grid_.name), what));
    }

    [[nodiscard]] std::size_t root_offset() const
    {
        const auto offset = at<std::uint64_t>(bytes_, kGridBytes + 24);
        if (offset < kTreeBytes || offset % kAlignment != 0 || offset > nano_.size - kGridBytes ||
            nano_.size - kGridBytes - offset < nodes_.root_size)
            fail(fmt::format("its root is said to be at byte {} of {}", offset, nano_.size));
        return kGridBytes + std::size_t(offset);
    }

    [[nodiscard]] std::size_t size_of(std::size_t level) const
    {
        return level == 0 ? nodes_.leaf_size : nodes_.node_size(level == 1 ? 512 : 4096);
    }

    /// The offset of a child, found good.
    std::size_t follow(std::size_t from, std::int64_t by, std::size_t level)
    {
        // A sum that wraps round is caught as any other that is out of the buffer.
        const std::size_t to = from + std::size_t(by);
        if (to < tiles_end_ || to > nano_.size || nano_.size - to < size_of(level) ||
            to % kAlignment != 0)
            fail(fmt::format("a node of level {} is said to be {} bytes from byte {} of {}", level,
                             by, from, nano_.size));
        visited_[level].push_back(to);
        if (visited_[level].size() > counts_[level])
            fail(fmt::format("more nodes of level {} than the {} that are said to be", level,
                             counts_[level]));
        return to;
    }

    /// 20 bits of a coordinate each, the rest 0.
    [[nodiscard]] glm::ivec3 origin_of(std::uint64_t key) const
    {
        glm::ivec3 origin;
        for (int axis = 0; axis < 3; ++axis) {
            const std::uint64_t part = key >> (42 - 21 * axis) & ((1u << 21) - 1);
            if (part >> 20 || key >> 63)
                fail(fmt::format("a tile of the root has the key {:#x}", key));
            origin[axis] = std::int32_t(std::uint32_t(part) << 12);
        }
        return origin;
    }

    static bool bit(const char* mask, std::size_t i) { return mask[i / 8] >> (i % 8) & 1; }

    void node(std::size_t offset, int log2_dim, glm::ivec3 origin, NanoVisitor& visitor)
    {
        check_cancelled(layout_.file);
        const std::size_t mask_bytes = (std::size_t(1) << (3 * log2_dim)) / 8;
        const int child_dim = log2_dim == 5 ? 128 : 8;
        const std::size_t child_level = log2_dim == 5 ? 1 : 0;
        const char* active = bytes_ + offset + 32;
        const char* children = active + mask_bytes;
        const std::size_t table = offset + nodes_.table(mask_bytes);
        for (std::size_t i = 0; i < 8 * mask_bytes; ++i) {
            const std::size_t entry = table + i * nodes_.entry;
            const glm::ivec3 at_child =
                origin + child_dim * glm::ivec3(int(i >> (2 * log2_dim)),
                                                int(i >> log2_dim) & ((1 << log2_dim) - 1),
                                                int(i) & ((1 << log2_dim) - 1));
            if (!bit(children, i)) {
                visitor.tile(at_child, child_dim, bytes_ + entry, bit(active, i));
                continue;
            }
            const std::size_t child = follow(offset, at<std::int64_t>(bytes_, entry), child_level);
            if (log2_dim == 5)
                node(child, 4, at_child, visitor);
            else
                leaf(child, at_child, visitor);
        }
    }

    void leaf(std::size_t offset, glm::ivec3 origin, NanoVisitor& visitor)
    {
        const char* leaf = bytes_ + offset;
        // It has the least corner of its active box, of which the rest is its own place.
        const auto corner = at<glm::ivec3>(leaf, 0);
        if (glm::ivec3(corner.x & ~7, corner.y & ~7, corner.z & ~7) != origin)
            fail(fmt::format("a leaf of ({}, {}, {}) where that of ({}, {}, {}) belongs", corner.x,
                             corner.y, corner.z, origin.x, origin.y, origin.z));
        std::array<std::uint64_t, kLeafCount / 64> active;
        std::memcpy(active.data(), leaf + 16, sizeof(active));
        if (const unsigned bits = code_bits(nano_.value, leaf)) {
            if (bits > 16 || nano_.size - offset < leaf_bytes(offset))
                fail(fmt::format("a leaf of values of {} bits", bits));
            std::array<float, kLeafCount> values;
            decode(leaf, nodes_.leaf_codes, bits, values);
            visitor.leaf(origin, values.data(), active.data());
        } else {
            // A buffer may begin anywhere in a file, and numbers must not.
            values_.resize(kLeafCount * nodes_.value / sizeof(double));
            std::memcpy(values_.data(), leaf + nodes_.leaf_codes, kLeafCount * nodes_.value);
            visitor.leaf(origin, values_.data(), active.data());
        }
    }

    [[nodiscard]] std::size_t leaf_bytes(std::size_t offset) const
    {
        return nano_.value == NanoValue::fpn
                   ? nodes_.leaf_codes + kLeafCount / 8 * code_bits(nano_.value, bytes_ + offset)
                   : nodes_.leaf_size;
    }

    const VdbLayout& layout_;
    const VdbGridLayout& grid_;
    const NanoGrid& nano_;
    const NodeLayout nodes_;
    const char* const bytes_;
    std::size_t tiles_end_ = 0;
    std::array<std::uint64_t, 3> counts_{};            ///< counts of leaves, lower and upper nodes
    std::array<std::vector<std::size_t>, 3> visited_;  ///< where they begin
    std::vector<double> values_;
};

class SeesNothing : public NanoVisitor {
public:
    void background(const void*) override {}
    void tile(glm::ivec3, int, const void*, bool) override {}
    void leaf(glm::ivec3, const void*, const std::uint64_t*) override {}
};

// Two CRCs, of what stands before the nodes and of the nodes; either may be left out.
// Version 32.6.1 has other rules than those before, and 32.4 hashes the hashes of nodes as numbers
// of 8 bytes.
void TreeWalk::check_sums() const
{
    constexpr std::uint32_t kNone = 0xffffffff;
    constexpr std::size_t kUnhashed = 16;  // magic and the sums themselves
    constexpr std::size_t kHeadEnd = kGridBytes + kTreeBytes;
    const auto head = at<std::uint32_t>(bytes_, 8), tail = at<std::uint32_t>(bytes_, 12);
    const auto version = at<std::uint32_t>(bytes_, 16);
    const bool old_rules = version <= (kMajor << 21 | 6u << 10);
    if (head == kNone)
        return;
    const std::size_t head_end = old_rules ? tiles_end_ : kHeadEnd;
    // Programs that put several grids into a buffer number them, and don't hash them anew.
    const bool merged = at<std::uint32_t>(bytes_, kGridCount) > 1;
    if (!merged && crc(bytes_ + kUnhashed, head_end - kUnhashed) != head)
        fail("its checksum is not that of its head");
    if (tail == kNone)
        return;
    const auto of_all = [](const auto& sums) {
        return crc(reinterpret_cast<const char*>(sums.data()), sums.size() * sizeof(sums[0]));
    };
    std::vector<std::uint64_t> wide;
    std::vector<std::uint32_t> narrow;
    if (old_rules) {
        for (const std::size_t level : {2u, 1u, 0u})
            for (const std::size_t node : visited_[level]) {
                wide.push_back(crc(bytes_ + node, size_of(level)));
                narrow.push_back(
                    crc(bytes_ + node, level == 0 ? leaf_bytes(node) : size_of(level)));
            }
    } else {
        constexpr std::size_t kBlock = 4096;  // the last has what is left over, too
        const std::size_t blocks = (nano_.size - kHeadEnd) / kBlock;
        for (std::size_t i = 0; i < blocks; ++i) {
            const std::size_t begin = kHeadEnd + i * kBlock;
            narrow.push_back(crc(bytes_ + begin, i + 1 == blocks ? nano_.size - begin : kBlock));
        }
    }
    if (of_all(narrow) != tail && (wide.empty() || of_all(wide) != tail))
        fail("its checksum is not that of its values");
}

/// Reads the segments of a file.
class Reader {
public:
    Reader(VdbLayout& layout, LazyBytes& bytes, VdbDepth depth)
        : layout_(layout), bytes_(bytes), depth_(depth)
    {
    }

    void run();

private:
    [[noreturn]] void fail(const std::string& what) const
    {
        throw Error(fmt::format("{}: damaged or cut short: {} (at byte {} of {})",
                                layout_.file.string(), what, at_, layout_.size));
    }

    const char* take(std::uint64_t count, const char* what)
    {
        if (count > layout_.size - at_)
            fail(fmt::format("{} runs past the end, {} bytes asked", what, count));
        bytes_.need(at_, at_ + count);
        const char* bytes = layout_.bytes.get() + at_;
        at_ += count;
        return bytes;
    }

    VdbGridLayout metadata(Codec codec);
    void buffer(VdbGridLayout grid, Codec codec);
    void walk(VdbGridLayout& grid);
    void expand(VdbGridLayout& grid, Codec codec, std::size_t end, char* out, std::size_t size);
    void describe(VdbGridLayout& grid, const char* head);

    VdbLayout& layout_;
    LazyBytes& bytes_;
    VdbDepth depth_;
    std::size_t at_ = 0;
    std::uint64_t memory_ = 0;  ///< bytes that expanded buffers take
};

std::string version_text(std::uint32_t version)
{
    return fmt::format("{}.{}.{}", version >> 21, version >> 10 & 2047, version & 1023);
}

void set_type(VdbGridLayout& grid, std::uint32_t type, std::uint32_t grid_class)
{
    grid.value_type = type < kTypeNames.size() ? kTypeNames[type] : fmt::format("type {}", type);
    struct Type {
        std::string_view name;
        NanoValue stored;
        VdbValue value;
    };
    static constexpr std::array kTypes = {Type{"float", NanoValue::float32, VdbValue::float32},
                                          Type{"double", NanoValue::float64, VdbValue::float64},
                                          Type{"vec3s", NanoValue::vec3f, VdbValue::vec3f},
                                          Type{"Fp4", NanoValue::fp4, VdbValue::float32},
                                          Type{"Fp8", NanoValue::fp8, VdbValue::float32},
                                          Type{"Fp16", NanoValue::fp16, VdbValue::float32},
                                          Type{"FpN", NanoValue::fpn, VdbValue::float32}};
    for (const Type& known : kTypes)
        if (known.name == grid.value_type) {
            grid.value = known.value;
            grid.nano->value = known.stored;
        }
    constexpr std::array kClasses = {"unknown", "level set", "fog volume", "staggered"};
    grid.grid_class = grid_class < kClasses.size() ? kClasses[grid_class] : "unknown";
}

/// A grid by what stands before its buffer.
VdbGridLayout Reader::metadata(Codec codec)
{
    const char* meta = take(kMetaBytes, "metadata");
    // The bytes may move when more are read.
    std::array<char, kMetaBytes> copy;
    std::memcpy(copy.data(), meta, kMetaBytes);
    meta = copy.data();
    VdbGridLayout grid;
    const auto name_size = at<std::uint32_t>(meta, 136);
    const char* name = take(name_size, "a grid's name");
    grid.name.assign(name, strnlen(name, name_size));

    auto nano = std::make_shared<NanoGrid>();
    nano->size = std::size_t(at<std::uint64_t>(meta, 0));
    grid.tree_end = std::size_t(at<std::uint64_t>(meta, 8));  // its bytes in the file, for now
    if (Codec(at<std::uint16_t>(meta, 168)) != codec)
        fail(fmt::format("grid '{}' is packed otherwise than its file", printable(grid.name)));
    grid.nano = std::move(nano);
    set_type(grid, at<std::uint32_t>(meta, 32), at<std::uint32_t>(meta, 36));
    const auto voxels = at<std::uint64_t>(meta, 24);
    const auto lo = at<glm::ivec3>(meta, 88), hi = at<glm::ivec3>(meta, 100);
    const bool empty = glm::any(glm::greaterThan(lo, hi));
    if (!empty) {
        grid.claimed_min = lo;
        grid.claimed_max = hi;
    }
    grid.claims =
        voxels <= std::uint64_t(std::numeric_limits<std::int64_t>::max()) && (voxels == 0) == empty;
    if (grid.claims)
        grid.claimed_voxels = std::int64_t(voxels);
    return grid;
}

/// The first `size` bytes of a buffer, from the file's bytes up to `end`.
void Reader::expand(VdbGridLayout& grid, Codec codec, std::size_t end, char* out, std::size_t size)
{
    const std::size_t whole = grid.nano->size;
    const auto damaged = [&] {
        fail(fmt::format("the packed values of grid '{}' don't expand as they should",
                         printable(grid.name)));
    };
    for (std::size_t done = 0; done < size;) {
        check_cancelled(layout_.file);
        const std::size_t chunk =
            codec == Codec::blosc ? std::min(whole - done, kChunkBytes) : whole;
        const auto stored = at<std::uint64_t>(take(8, "the size of packed values"), 0);
        if (at_ > end || stored > end - at_)
            fail(fmt::format("packed values of {} bytes", stored));
        const char* packed = take(stored, "packed values");
        const std::size_t wanted = std::min(chunk, size - done);
        if (codec == Codec::blosc) {
            // Blosc believes the sizes in its own header: version, flags, then what comes out, the
            // size of a block, and what goes in.
            std::array<std::uint32_t, 4> header{};
            if (stored < sizeof(header))
                damaged();
            std::memcpy(header.data(), packed, sizeof(header));
            const std::size_t item = std::uint8_t(packed[3]);
            if (header[1] != chunk || header[3] != stored || item == 0 || wanted % item != 0)
                damaged();
            const bool good =
                wanted == chunk
                    ? blosc_decompress_ctx(packed, out + done, chunk, 1) == int(chunk)
                    : blosc_getitem(packed, 0, int(wanted / item), out + done) == int(wanted);
            if (!good)
                damaged();
        } else {
            z_stream stream{};
            if (inflateInit(&stream) != Z_OK)
                damaged();
            // zlib counts in 32 bits.
            constexpr std::size_t kMost = std::size_t(1) << 30;
            std::size_t in = stored, left = wanted;
            stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed));
            stream.next_out = reinterpret_cast<Bytef*>(out);
            int status = Z_OK;
            while (status == Z_OK && (left > 0 || wanted == chunk)) {
                const uInt give = uInt(std::min(in, kMost)), room = uInt(std::min(left, kMost));
                stream.avail_in = give;
                stream.avail_out = room;
                status = inflate(&stream, Z_NO_FLUSH);
                in -= give - stream.avail_in;
                left -= room - stream.avail_out;
            }
            inflateEnd(&stream);
            if (left > 0 || (wanted == chunk && status != Z_STREAM_END))
                damaged();
        }
        done += wanted;
    }
    if (size == whole && at_ != end)
        fail(fmt::format("the values of grid '{}' end before byte {}", printable(grid.name), end));
}

/// What a buffer says of itself and is needed before its tree is walked.
void Reader::describe(VdbGridLayout& grid, const char* head)
{
    if (std::memcmp(head, kMagic.data(), kMagic.size()) != 0)
        fail(fmt::format("grid '{}' does not begin as one", printable(grid.name)));
    const auto size = at<std::uint64_t>(head, kGridSize);
    if (size > grid.nano->size || size < kGridBytes + kTreeBytes)
        fail(fmt::format("grid '{}' is said to have {} bytes, and {}", printable(grid.name),
                         grid.nano->size, size));
    const std::string type = grid.value_type;
    set_type(grid, at<std::uint32_t>(head, kGridType), at<std::uint32_t>(head, kGridClass));
    if (!type.empty() && type != grid.value_type)
        fail(fmt::format("grid '{}' is said to be of type {}, and {}", printable(grid.name), type,
                         grid.value_type));
    grid.transform = "NanoVDB map";
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            grid.world_from_index[column][row] =
                at<double>(head, kGridMatrix + 8 * std::size_t(3 * row + column));
        grid.world_from_index[3][row] = at<double>(head, kGridOffset + 8 * std::size_t(row));
    }
    grid.transform_refusal = transform_refusal(grid.world_from_index);
}

/// Walks a grid of which `nano` has all bytes and maybe more.
void Reader::walk(VdbGridLayout& grid)
{
    const NanoGrid& nano = *grid.nano;
    const char* head = (nano.expanded ? nano.expanded->data() : layout_.bytes.get()) + nano.begin;
    describe(grid, head);
    grid.nano->size = std::size_t(at<std::uint64_t>(head, kGridSize));
    if (grid.value == VdbValue::other)
        return;
    TreeWalk walk(layout_, grid);
    SeesNothing nobody;
    walk.run(nobody);
    walk.check_sums();
    grid.leaves = walk.leaves();
    grid.tree_bytes = walk.expanded_bytes();
}

/// Reads the buffer of a grid, in which other grids may follow.
void Reader::buffer(VdbGridLayout grid, Codec codec)
{
    const std::size_t stored = grid.tree_end;
    grid.tree_begin = at_;
    if (stored > layout_.size - at_)
        fail(fmt::format("grid '{}' runs past the end, {} bytes asked", printable(grid.name),
                         stored));
    const std::size_t end = grid.tree_end = at_ + stored;
    NanoGrid& nano = *grid.nano;
    if (nano.size < kGridBytes + kTreeBytes)
        fail(fmt::format("grid '{}' of {} bytes", printable(grid.name), nano.size));
    if (codec == Codec::none && nano.size != stored)
        fail(fmt::format("grid '{}' is said to have {} bytes, and {}", printable(grid.name),
                         nano.size, stored));
    const std::size_t size = depth_ == VdbDepth::all ? nano.size : kGridBytes;
    const char* head = nullptr;
    if (codec == Codec::none) {
        nano.begin = at_;
        head = take(size, "a grid");
    } else {
        constexpr std::uint64_t kFarTooMuch = std::uint64_t(1) << 62;  // no sum may wrap round
        memory_ += std::min<std::uint64_t>(size, kFarTooMuch);
        check_memory(layout_.file, layout_.size + memory_);
        const auto expanded = std::make_shared<std::vector<char>>(size);
        expand(grid, codec, end, expanded->data(), size);
        head = expanded->data();
        nano.expanded = expanded;
    }
    at_ = end;
    const auto count = at<std::uint32_t>(head, kGridCount);
    if (depth_ == VdbDepth::headers) {
        describe(grid, head);
        grid.claims = grid.claims && count <= 1;
        layout_.grids.push_back(std::move(grid));
        return;
    }
    const std::size_t buffer_end = nano.begin + nano.size;
    walk(grid);
    std::size_t at_grid = nano.begin + nano.size;
    layout_.grids.push_back(std::move(grid));
    for (std::uint32_t i = 1; i < count && buffer_end - at_grid >= kGridBytes + kTreeBytes; ++i) {
        const VdbGridLayout& before = layout_.grids.back();
        VdbGridLayout next;
        next.nano = std::make_shared<NanoGrid>(*before.nano);
        next.nano->begin = at_grid;
        next.nano->size = buffer_end - at_grid;
        next.tree_begin = before.tree_begin + 1;  // of its own, as a key
        next.tree_end = end;
        const char* name =
            (next.nano->expanded ? next.nano->expanded->data() : layout_.bytes.get()) + at_grid +
            kGridName;
        next.name.assign(name, strnlen(name, kGridNameBytes));
        walk(next);
        at_grid += next.nano->size;
        layout_.grids.push_back(std::move(next));
    }
}

void Reader::run()
{
    while (at_ < layout_.size) {
        const char* header = take(kHeaderBytes, "a header");
        if (std::memcmp(header, kMagic.data(), kMagic.size()) != 0)
            fail("a header that is not NanoVDB's");
        const auto version = at<std::uint32_t>(header, 8);
        if (version >> 21 != kMajor)
            throw Error(fmt::format("{}: NanoVDB {}, and {} is read: save it anew with another "
                                    "program",
                                    layout_.file.string(), version_text(version), kMajor));
        layout_.creator = "NanoVDB " + version_text(version);
        const auto count = at<std::uint16_t>(header, 12);
        const auto codec = Codec(at<std::uint16_t>(header, 14));
        if (codec > Codec::blosc)
            fail(fmt::format("packed in an unknown way ({})", int(codec)));
        std::vector<VdbGridLayout> grids;
        grids.reserve(std::min<std::size_t>(count, (layout_.size - at_) / kMetaBytes));
        for (int i = 0; i < count; ++i)  // as many as the file has, whatever it says
            grids.emplace_back(metadata(codec));
        for (VdbGridLayout& grid : grids)
            buffer(std::move(grid), codec);
    }
}

}  // namespace

}  // namespace nanovdb_file

bool is_nanovdb(const VdbLayout& layout, LazyBytes& bytes)
{
    if (layout.size < nanovdb_file::kMagic.size())
        return false;
    bytes.need(0, nanovdb_file::kMagic.size());
    return std::memcmp(layout.bytes.get(), nanovdb_file::kMagic.data(),
                       nanovdb_file::kMagic.size()) == 0;
}

void read_nanovdb_layout(VdbLayout& layout, LazyBytes& bytes, VdbDepth depth)
{
    nanovdb_file::Reader(layout, bytes, depth).run();
}

void visit_nanovdb(const VdbLayout& layout, const VdbGridLayout& grid, NanoVisitor& visitor)
{
    nanovdb_file::TreeWalk(layout, grid).run(visitor);
}

}  // namespace fumarole::asset
