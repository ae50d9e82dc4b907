#include "asset/vdb_layout.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <optional>
#include <string_view>

#include "asset/lazy_bytes.h"
#include "asset/nanovdb_layout.h"
#include "asset/printable.h"
#include <fumarole/asset/load_limits.h>
#include <fumarole/errors.h>

// The format is that of OpenVDB's io::Archive and tree nodes, file versions 222 (OpenVDB 1.0, 2012)
// to 224 (today's). Numbers are little endian. A file is
//
//   magic, versions, a flag whether offsets are meant, UUID, metadata, number of grids, and per
//   grid: descriptor (names, type, three offsets), compression flags, metadata, transform, tree.
//
// A tree is its topology (background, tiles, and depth first every node's masks and tile values),
// then the buffers of all leaves in the same order, except that children of the root come there in
// the order of their coordinates.

namespace fumarole::asset {

static_assert(std::endian::native == std::endian::little, "a .vdb is read as it lies in memory");

namespace {

constexpr std::uint32_t kMagic = 0x56444220;
constexpr std::uint32_t kOldestVersion = 222;
constexpr std::uint32_t kNewestVersion = 224;
constexpr std::size_t kUuidBytes = 36;
constexpr std::size_t kLeafMaskBytes = 512 / 8;
constexpr std::size_t kLeafBytes = 128;  // of memory that a leaf takes beside its values
constexpr std::int32_t kRootChildDim = 4096;

constexpr std::uint32_t kZip = 1;
constexpr std::uint32_t kActiveMask = 2;
constexpr std::uint32_t kBlosc = 4;

/// A zip chunk: where, and how many bytes must come out.
struct ZipChunk {
    std::size_t begin;
    std::size_t compressed;
    std::size_t expanded;
};

class Walk {
public:
    Walk(VdbLayout& layout, LazyBytes& bytes, VdbDepth depth)
        : layout_(layout), bytes_(bytes), depth_(depth)
    {
    }

    void run();

private:
    struct Metadata {
        std::map<std::string, std::string> text;
        std::map<std::string, glm::ivec3> vec3i;
        std::map<std::string, std::int64_t> int64;
        std::map<std::string, bool> boolean;
    };

    /// What a chunk of tree values is made of.
    struct Values {
        std::size_t bytes;  ///< bytes of one value in memory, and of backgrounds and tiles of root
        std::size_t stored_bytes;  ///< bytes of one value in a chunk, where halves may be asked for
        bool half;
        std::uint32_t compression;
    };

    [[noreturn]] void fail_at(std::size_t byte, const std::string& what) const
    {
        throw Error(fmt::format("{}: damaged or cut short: {} (at byte {} of {})",
                                layout_.file.string(), what, byte, layout_.size));
    }
    [[noreturn]] void fail(const std::string& what) const { fail_at(at_, what); }

    const char* take(std::uint64_t count, const char* what)
    {
        if (count > end_ - at_)
            fail(fmt::format("{} runs past the end, {} bytes asked", what, count));
        bytes_.need(at_, at_ + count);
        const char* bytes = layout_.bytes.get() + at_;
        at_ += count;
        return bytes;
    }

    template <class T> T get(const char* what)
    {
        T value;
        std::memcpy(&value, take(sizeof(T), what), sizeof(T));
        return value;
    }

    std::string get_string(const char* what)
    {
        const auto length = get<std::uint32_t>(what);
        return {take(length, what), length};
    }

    void header();
    Metadata metadata();
    void transform(VdbGridLayout& grid);
    void tree(VdbGridLayout& grid);
    void node(const Values& values, int log2_dim, VdbGridLayout& grid);
    void values(const Values& values, const char* mask, std::size_t count);
    void chunk(const Values& values, std::size_t count);
    void check_zip_chunks() const;

    VdbLayout& layout_;
    LazyBytes& bytes_;
    VdbDepth depth_;
    std::size_t at_ = 0;
    std::size_t end_ = 0;  ///< nothing is read from here on
    std::vector<ZipChunk> zip_chunks_;
};

std::size_t count_on(const char* mask, std::size_t bytes)
{
    std::size_t on = 0;
    for (std::size_t i = 0; i < bytes; i += 8) {
        std::uint64_t word;
        std::memcpy(&word, mask + i, 8);
        on += std::size_t(std::popcount(word));
    }
    return on;
}

void Walk::header()
{
    const std::string file = layout_.file.string();
    if (layout_.size < 8)
        throw Error(fmt::format("{}: not an OpenVDB file: {} bytes", file, layout_.size));
    if (get<std::uint32_t>("header") != kMagic)
        throw Error(fmt::format("{}: not an OpenVDB file", file));
    get<std::uint32_t>("header");

    layout_.file_version = get<std::uint32_t>("header");
    if (layout_.file_version < kOldestVersion)
        throw Error(fmt::format("{}: file version {} is older than OpenVDB 1.0 ({}): save it anew "
                                "with a newer program",
                                file, layout_.file_version, kOldestVersion));
    if (layout_.file_version > kNewestVersion)
        throw Error(fmt::format("{}: file version {} is not known, {} is the newest that is read",
                                file, layout_.file_version, kNewestVersion));
    layout_.library_major = get<std::uint32_t>("header");
    layout_.library_minor = get<std::uint32_t>("header");
}

Walk::Metadata Walk::metadata()
{
    Metadata result;
    const auto count = get<std::uint32_t>("metadata");
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::string name = get_string("metadata");
        const std::string type = get_string("metadata");
        const auto size = get<std::uint32_t>("metadata");
        const char* bytes = take(size, "metadata");
        if (type == "string") {
            result.text[name].assign(bytes, size);
        } else if (type == "vec3i" && size == sizeof(glm::ivec3)) {
            std::memcpy(&result.vec3i[name], bytes, size);
        } else if (type == "int64" && size == sizeof(std::int64_t)) {
            std::memcpy(&result.int64[name], bytes, size);
        } else if (type == "bool" && size == 1) {
            result.boolean[name] = *bytes != 0;
        }
    }
    return result;
}

void Walk::transform(VdbGridLayout& grid)
{
    const auto read_linear = [this](const std::string& type) -> std::optional<glm::dmat4> {
        glm::dmat4 matrix(1.0);
        if (type == "AffineMap" || type == "UnitaryMap") {
            // Row vectors, row after row, is what column vectors are column after column.
            std::memcpy(&matrix, take(sizeof(matrix), "transform"), sizeof(matrix));
        } else if (type == "TranslationMap") {
            matrix[3] = glm::dvec4(get<glm::dvec3>("transform"), 1);
        } else if (type.ends_with("ScaleMap") || type.ends_with("ScaleTranslateMap")) {
            if (type.ends_with("TranslateMap"))
                matrix[3] = glm::dvec4(get<glm::dvec3>("transform"), 1);
            const auto scale = get<glm::dvec3>("transform");
            for (int axis = 0; axis < 3; ++axis)
                matrix[axis][axis] = scale[axis];
            // Voxel size, inverse, and two more: all follow from the scale.
            take(4 * sizeof(glm::dvec3), "transform");
        } else {
            return std::nullopt;
        }
        return matrix;
    };

    grid.transform = get_string("transform");
    if (grid.transform == "NonlinearFrustumMap") {
        take(sizeof(double[8]), "transform");  // box, taper, depth
        if (!read_linear(get_string("transform")))
            fail("the transform of a frustum is of an unknown type");
        grid.transform_refusal = "its transform is a camera frustum; resample it to a box";
        return;
    }
    const auto matrix = read_linear(grid.transform);
    if (!matrix)
        fail(fmt::format("transform of unknown type '{}'", printable(grid.transform)));
    grid.world_from_index = *matrix;

    grid.transform_refusal = transform_refusal(*matrix);
}

void Walk::chunk(const Values& values, std::size_t count)
{
    if (values.half && count == 0)
        return;  // OpenVDB writes nothing at all then
    const std::size_t expanded = count * values.stored_bytes;
    if (!(values.compression & (kZip | kBlosc))) {
        take(expanded, "values");
        return;
    }
    const auto stored = get<std::int64_t>("size of compressed values");
    if (stored <= 0) {  // not worth compressing
        if (stored == std::numeric_limits<std::int64_t>::min() ||
            std::uint64_t(-stored) != expanded)
            fail(fmt::format("{} bytes of values where {} belong", stored, expanded));
        take(expanded, "values");
        return;
    }
    const std::size_t begin = at_;
    const char* bytes = take(std::uint64_t(stored), "compressed values");
    if (values.compression & kBlosc) {
        // Blosc believes the sizes in its own header: version, flags, then what comes out, the
        // size of a block, and what goes in.
        std::array<std::uint32_t, 4> blosc{};
        if (std::size_t(stored) < sizeof(blosc))
            fail("compressed values without a header");
        std::memcpy(blosc.data(), bytes, sizeof(blosc));
        if (blosc[1] != expanded || blosc[3] != std::uint64_t(stored))
            fail(fmt::format("values of {} bytes packed into {}, where {} in {} belong", blosc[1],
                             blosc[3], expanded, stored));
    } else {
        zip_chunks_.push_back({begin, std::size_t(stored), expanded});
    }
}

void Walk::values(const Values& values, const char* mask, std::size_t count)
{
    // Which inactive values were left out, and what stands for them; names are OpenVDB's.
    enum : std::uint8_t {
        no_mask_and_one_inactive_val = 2,
        mask_and_no_inactive_vals = 3,
        mask_and_one_inactive_val = 4,
        mask_and_two_inactive_vals = 5,
        no_mask_and_all_vals = 6,
    };
    const auto kind = get<std::uint8_t>("values");
    if (kind > no_mask_and_all_vals)
        fail(fmt::format("values stored in an unknown way ({})", kind));
    if (kind == no_mask_and_one_inactive_val || kind == mask_and_one_inactive_val)
        take(values.bytes, "inactive value");
    if (kind == mask_and_two_inactive_vals)
        take(2 * values.bytes, "inactive values");
    if (kind >= mask_and_no_inactive_vals && kind <= mask_and_two_inactive_vals)
        take(count / 8, "mask of inactive values");

    const bool active_only = (values.compression & kActiveMask) && kind != no_mask_and_all_vals;
    chunk(values, active_only ? count_on(mask, count / 8) : count);
}

void Walk::node(const Values& values, int log2_dim, VdbGridLayout& grid)
{
    check_cancelled(layout_.file);
    const std::size_t count = std::size_t(1) << (3 * log2_dim);
    // Of OpenVDB's nodes: a value or a pointer in each place, and two masks.
    grid.tree_bytes += count * std::max(values.bytes, sizeof(void*)) + count / 4;
    const char* children = take(count / 8, "child mask");
    const char* active = take(count / 8, "value mask");
    for (std::size_t i = 0; i < count / 8; ++i)
        if (children[i] & active[i])
            fail("a node has a child and a value in one place");
    this->values(values, active, count);

    const std::size_t child_count = count_on(children, count / 8);
    if (log2_dim == 4) {  // its children are leaves, of which the topology holds the masks
        take(child_count * kLeafMaskBytes, "leaf masks");
        grid.leaves += child_count;
        grid.tree_bytes += child_count * (512 * values.bytes + kLeafBytes);
        return;
    }
    for (std::size_t i = 0; i < child_count; ++i)
        node(values, 4, grid);
}

void Walk::tree(VdbGridLayout& grid)
{
    Values values{};
    values.half = grid.half;
    values.compression = grid.compression;
    switch (grid.value) {
    case VdbValue::float32:
        values.bytes = sizeof(float);
        break;
    case VdbValue::float64:
        values.bytes = sizeof(double);
        break;
    case VdbValue::vec3f:
        values.bytes = sizeof(float[3]);
        break;
    case VdbValue::vec3d:
        values.bytes = sizeof(double[3]);
        break;
    case VdbValue::other:
        return;
    }
    const bool vector = grid.value == VdbValue::vec3f || grid.value == VdbValue::vec3d;
    values.stored_bytes = !grid.half ? values.bytes : vector ? 6 : 2;

    grid.tree_begin = grid.tree_end = at_;
    if (depth_ == VdbDepth::headers)
        return;
    if (get<std::int32_t>("tree") != 1)
        fail("a tree with several buffers");
    take(values.bytes, "background");
    const auto tiles = get<std::uint32_t>("tree");
    const auto children = get<std::uint32_t>("tree");

    // OpenVDB loses track of a child whose place is given twice. A place costs the file more bytes
    // than memory here, so a forged count can't ask for much.
    std::vector<std::array<std::int32_t, 3>> origins;
    const auto get_origin = [&] {
        origins.push_back(get<std::array<std::int32_t, 3>>("tree"));
        for (const std::int32_t x : origins.back())
            if (x % kRootChildDim != 0)
                fail(fmt::format("a node at {}, which is no multiple of {}", x, kRootChildDim));
    };
    for (std::uint32_t i = 0; i < tiles; ++i) {
        get_origin();
        take(values.bytes, "tile");
        if (get<std::uint8_t>("tile") > 1)
            fail("a tile that is neither active nor inactive");
    }
    for (std::uint32_t i = 0; i < children; ++i) {
        get_origin();
        node(values, 5, grid);
    }
    std::ranges::sort(origins);
    if (std::ranges::adjacent_find(origins) != origins.end())
        fail("two nodes in one place");

    for (std::uint64_t i = 0; i < grid.leaves; ++i) {
        if (i % 4096 == 0)
            check_cancelled(layout_.file);
        const char* mask = take(kLeafMaskBytes, "leaf");
        this->values(values, mask, 512);
    }
    grid.tree_end = at_;
}

void Walk::check_zip_chunks() const
{
    // OpenVDB only warns where a checksum is wrong.
    std::atomic<std::size_t> bad{std::numeric_limits<std::size_t>::max()};
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, zip_chunks_.size(), 64), [&](const auto& range) {
            check_cancelled(layout_.file);
            std::vector<char> out;
            for (std::size_t i = range.begin(); i != range.end(); ++i) {
                const ZipChunk& chunk = zip_chunks_[i];
                out.resize(std::max<std::size_t>(chunk.expanded, 1));
                uLongf expanded = uLongf(chunk.expanded);
                const int status =
                    uncompress(reinterpret_cast<Bytef*>(out.data()), &expanded,
                               reinterpret_cast<const Bytef*>(layout_.bytes.get() + chunk.begin),
                               uLong(chunk.compressed));
                if (status == Z_OK && expanded == chunk.expanded)
                    continue;
                std::size_t first = bad;
                while (chunk.begin < first && !bad.compare_exchange_weak(first, chunk.begin)) {
                }
            }
        });
    if (bad != std::numeric_limits<std::size_t>::max())
        fail_at(bad, "compressed values don't expand as they should");
}

void split_type(const std::string& full, VdbGridLayout& grid)
{
    constexpr std::string_view kHalf = "_HalfFloat";
    constexpr std::string_view kTree = "Tree_";
    constexpr std::string_view kShape = "_5_4_3";
    std::string_view type = full;
    if (type.ends_with(kHalf))
        type.remove_suffix(kHalf.size());
    bool known = type.starts_with(kTree) && type.ends_with(kShape);
    if (known) {
        type.remove_prefix(kTree.size());
        type.remove_suffix(std::min(kShape.size(), type.size()));
    }
    grid.value_type = printable(type);
    if (known && type == "float")
        grid.value = VdbValue::float32;
    else if (known && type == "double")
        grid.value = VdbValue::float64;
    else if (known && type == "vec3s")
        grid.value = VdbValue::vec3f;
    else if (known && type == "vec3d")
        grid.value = VdbValue::vec3d;
}

/// Tells grids of one name, or of none, apart by a number.
void give_addresses(std::vector<VdbGridLayout>& grids)
{
    std::map<std::string, int> repeats, seen;
    for (const VdbGridLayout& grid : grids)
        ++repeats[grid.name];
    for (VdbGridLayout& grid : grids) {
        const int index = seen[grid.name]++;
        grid.address = repeats[grid.name] > 1 || grid.name.empty()
                           ? fmt::format("{}[{}]", grid.name, index)
                           : grid.name;
    }
}

void Walk::run()
{
    end_ = layout_.size;
    header();
    const bool has_offsets = get<std::uint8_t>("header") != 0;
    if (!has_offsets)
        depth_ = VdbDepth::all;  // or nobody knows where the next grid begins
    take(kUuidBytes, "header");
    const Metadata about_file = metadata();
    if (const auto it = about_file.text.find("creator"); it != about_file.text.end())
        layout_.creator = printable(it->second);

    const auto count = get<std::int32_t>("number of grids");
    if (count < 0)
        fail(fmt::format("{} grids", count));
    std::map<std::string, std::size_t> unique_names;
    for (std::int32_t i = 0; i < count; ++i) {
        VdbGridLayout grid;
        const std::string unique_name = get_string("grid descriptor");
        grid.name = unique_name.substr(0, unique_name.find('\x1e'));
        split_type(get_string("grid descriptor"), grid);
        const std::string parent = get_string("grid descriptor");
        const auto begin = get<std::int64_t>("grid descriptor");
        take(sizeof(std::int64_t), "grid descriptor");  // where the leaves begin: not needed
        const auto end = get<std::int64_t>("grid descriptor");
        if (has_offsets) {
            if (begin < std::int64_t(at_) || end < begin || end > std::int64_t(layout_.size))
                fail(fmt::format("grid '{}' is said to be at bytes {} to {}", printable(grid.name),
                                 begin, end));
            at_ = std::size_t(begin);
            end_ = std::size_t(end);
        }

        grid.compression = get<std::uint32_t>("grid");
        if (grid.compression > (kZip | kActiveMask | kBlosc))
            fail(fmt::format("grid '{}' is compressed in an unknown way ({})", printable(grid.name),
                             grid.compression));
        const Metadata about = metadata();
        grid.text = about.text;
        if (const auto it = about.text.find("class"); it != about.text.end())
            grid.grid_class = it->second;
        if (grid.grid_class != "fog volume" && grid.grid_class != "level set" &&
            grid.grid_class != "staggered")
            grid.grid_class = "unknown";
        if (const auto it = about.boolean.find("is_saved_as_half_float");
            it != about.boolean.end() && grid.value != VdbValue::other)
            grid.half = it->second;
        const auto lo = about.vec3i.find("file_bbox_min"), hi = about.vec3i.find("file_bbox_max");
        if (lo != about.vec3i.end() && hi != about.vec3i.end() &&
            glm::all(glm::lessThanEqual(lo->second, hi->second))) {
            grid.claimed_min = lo->second;
            grid.claimed_max = hi->second;
        }
        if (const auto it = about.int64.find("file_voxel_count");
            it != about.int64.end() && it->second >= 0) {
            grid.claimed_voxels = it->second;
            grid.claims = lo != about.vec3i.end() && hi != about.vec3i.end() &&
                          (it->second == 0) == (grid.claimed_min.x > grid.claimed_max.x);
        }
        if (layout_.creator.empty())
            if (const auto it = about.text.find("creator"); it != about.text.end())
                layout_.creator = printable(it->second);
        transform(grid);

        if (parent.empty()) {
            if (grid.value == VdbValue::other && !has_offsets)
                fail(fmt::format("grid '{}' is of a type that is not read ({}), and the file "
                                 "doesn't say where it ends",
                                 printable(grid.name), grid.value_type));
            tree(grid);
        } else {  // shares the tree of a grid before it
            const auto it = unique_names.find(parent);
            if (it == unique_names.end() || layout_.grids[it->second].value != grid.value ||
                layout_.grids[it->second].half != grid.half)
                fail(fmt::format("grid '{}' shares the values of '{}', which don't suit it",
                                 printable(grid.name), printable(parent)));
            const VdbGridLayout& other = layout_.grids[it->second];
            grid.compression = other.compression;
            grid.tree_begin = other.tree_begin;
            grid.tree_end = other.tree_end;
            grid.leaves = other.leaves;
            grid.tree_bytes = other.tree_bytes;
        }
        if (has_offsets) {
            at_ = end_;
            end_ = layout_.size;
        }
        unique_names.emplace(unique_name, layout_.grids.size());
        layout_.grids.push_back(std::move(grid));
    }

    give_addresses(layout_.grids);
    check_zip_chunks();
}

}  // namespace

std::string transform_refusal(const glm::dmat4& world_from_index)
{
    std::string refusal;
    double product = 1;
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 4; ++row)
            if (!std::isfinite(world_from_index[column][row]))
                refusal = "its transform is not finite";
        if (world_from_index[column][3] != (column == 3 ? 1.0 : 0.0))
            refusal = "its transform is not affine";
        if (column < 3)
            product *= glm::length(glm::dvec3(world_from_index[column]));
    }
    // Relative to the voxel's edges, so that voxels of a micrometre are as good as any.
    const double volume = std::abs(glm::determinant(glm::dmat3(world_from_index)));
    if (refusal.empty() && !(volume > 1e-12 * product && std::isnormal(volume)))
        refusal = "its transform can't be inverted";
    return refusal;
}

VdbLayout read_vdb_layout(const std::filesystem::path& file, VdbDepth depth)
{
    VdbLayout layout;
    layout.file = file;
    check_file(file, "file");
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(file, error);
    std::ifstream in(file, std::ios::binary);
    if (error || !in)
        throw Error(fmt::format("{}: can't be read", file.string()));

    // A sparse file can claim any size for free.
    check_memory(file, size);
    layout.size = std::size_t(size);
    // Not mapped: the program that made the file may be overwriting it while we look.
    layout.bytes = std::make_unique_for_overwrite<char[]>(layout.size);
    LazyBytes bytes(std::move(in), layout);
    if (depth == VdbDepth::all)
        bytes.read_all();
    if (is_nanovdb(layout, bytes)) {
        read_nanovdb_layout(layout, bytes, depth);
        give_addresses(layout.grids);
    } else {
        Walk(layout, bytes, depth).run();
    }
    return layout;
}

}  // namespace fumarole::asset
