#include "study/reference_state.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <vector>

#include "study/reference_cache.h"
#include "write/whole_file.h"
#include <fumarole/asset/scene_file.h>
#include <fumarole/errors.h>

namespace fumarole::study {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// The file: kStateMagic, the length of the facts and the facts as JSON, width and height, a byte a
// pixel (1: finished), the floats of each finished pixel in the order of kStateLayers, and the hash
// of all that as its 16 digits. Numbers are as the processor has them: it goes on where it was
// made.
constexpr std::string_view kStateMagic = "fumarole unfinished reference 1\n";
constexpr std::size_t kHashDigits = 16;

struct StateLayer {
    std::vector<float> ReferenceStill::*pixels;
    std::size_t channels;
};

constexpr std::array kStateLayers{
    StateLayer{&ReferenceStill::composite, 3},       StateLayer{&ReferenceStill::scattering, 3},
    StateLayer{&ReferenceStill::transmittance, 3},   StateLayer{&ReferenceStill::surface, 3},
    StateLayer{&ReferenceStill::surface_lit, 3},     StateLayer{&ReferenceStill::depth, 1},
    StateLayer{&ReferenceStill::error, 1},           StateLayer{&ReferenceStill::noise, 3},
    StateLayer{&ReferenceStill::scattering_noise, 3}};

constexpr auto kFirstKept = std::chrono::milliseconds(500),
               kKeptEvery = std::chrono::milliseconds(2000);
// Keeping takes no more than this share of the time.
constexpr int kKeepShare = 20;
constexpr auto kLeaveOthers = std::chrono::seconds(10);

template <typename T> void append(std::string& to, std::span<const T> values)
{
    to.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
}

std::string packed(const ReferenceFacts& facts, const ReferenceStill& still,
                   const std::vector<char>& finished)
{
    const std::string named = nlohmann::json(facts).dump();
    std::string bytes(kStateMagic);
    const std::uint64_t length = named.size();
    append(bytes, std::span(&length, 1));
    bytes += named;
    const std::array<std::int32_t, 2> size{still.width, still.height};
    append(bytes, std::span<const std::int32_t>(size));
    append(bytes, std::span(finished));
    for (std::size_t i = 0; i < finished.size(); ++i)
        for (const StateLayer& layer : kStateLayers)
            if (finished[i] != 0)
                append(bytes, std::span<const float>(still.*layer.pixels)
                                  .subspan(i * layer.channels, layer.channels));
    return bytes + text_hash(bytes);
}

/// What a file of state that is whole says.
struct FoundState {
    ReferenceFacts facts;
    PartialReference partial;
};

/// The bytes of a file from front to back. @throws Error if there are fewer than asked for.
class StateBytes {
public:
    explicit StateBytes(std::string_view bytes) : left_{bytes} {}

    std::string_view take(std::size_t length)
    {
        if (length > left_.size())
            throw Error("it ends too early");
        const std::string_view taken = left_.substr(0, length);
        left_.remove_prefix(length);
        return taken;
    }
    template <typename T> void read(T* to, std::size_t count)
    {
        if (count > left_.size() / sizeof(T))
            throw Error("it ends too early");
        std::memcpy(to, take(count * sizeof(T)).data(), count * sizeof(T));
    }
    [[nodiscard]] bool at_end() const { return left_.empty(); }

private:
    std::string_view left_;
};

/// @throws Error that says what is wrong with the file, without its name.
FoundState unpacked(std::string_view bytes)
{
    if (!bytes.starts_with(kStateMagic))
        throw Error("it is no unfinished reference, or of another version");
    if (bytes.size() < kStateMagic.size() + kHashDigits)
        throw Error("it ends too early");
    const std::string_view content = bytes.substr(0, bytes.size() - kHashDigits);
    if (text_hash(content) != bytes.substr(content.size()))
        throw Error("its checksum is another");
    StateBytes from(content.substr(kStateMagic.size()));
    std::uint64_t length = 0;
    from.read(&length, 1);
    FoundState found;
    const nlohmann::json named = nlohmann::json::parse(from.take(length), nullptr, false);
    if (!named.is_object())
        throw Error("it does not say what it is of");
    for (const auto& [name, value] : named.items())
        found.facts[name] = value.is_string() ? value.get<std::string>() : value.dump();
    std::array<std::int32_t, 2> size{};
    from.read(size.data(), size.size());
    ReferenceStill& still = found.partial.still;
    still.width = size[0];
    still.height = size[1];
    if (still.width < 1 || still.height < 1)
        throw Error("it has no pixels");
    const std::size_t pixels =
        static_cast<std::size_t>(still.width) * static_cast<std::size_t>(still.height);
    const std::string_view finished = from.take(pixels);
    found.partial.finished.assign(finished.begin(), finished.end());
    for (const StateLayer& layer : kStateLayers)
        (still.*layer.pixels).resize(pixels * layer.channels);
    for (std::size_t i = 0; i < pixels; ++i)
        for (const StateLayer& layer : kStateLayers)
            if (found.partial.finished[i] != 0)
                from.read((still.*layer.pixels).data() + i * layer.channels, layer.channels);
    if (!from.at_end())
        throw Error("it has more in it than its pixels");
    return found;
}

/// `--tolerance was 0.01 and is 0.02, the scene's camera is another`.
std::string difference(const ReferenceFacts& was, const ReferenceFacts& is)
{
    constexpr std::string_view kNothing = "not there";
    constexpr std::size_t kShort = 40;  // longer values are of no use to a reader
    ReferenceFacts all = was;
    all.insert(is.begin(), is.end());
    std::vector<std::string> parts;
    for (const auto& [name, ignored] : all) {
        const auto of = [&name = name, kNothing](const ReferenceFacts& facts) {
            const auto at = facts.find(name);
            return at == facts.end() ? std::string(kNothing) : at->second;
        };
        const std::string before = of(was), now = of(is);
        if (before == now)
            continue;
        if (before.size() > kShort || now.size() > kShort)
            parts.push_back(fmt::format("{} changed", name));
        else
            parts.push_back(fmt::format("{} was {} and is {}", name, before, now));
    }
    return fmt::format("{}", fmt::join(parts, ", "));
}

double share_of(const std::vector<char>& finished)
{
    return static_cast<double>(std::count(finished.begin(), finished.end(), 1)) /
           static_cast<double>(finished.size());
}

/// What an earlier run left, if it can be gone on from; what is there and can't be is told.
/// @param others is set if the file is of another reference
std::optional<PartialReference> found_state(const ReferenceState& state, glm::ivec2 size,
                                            bool& others)
{
    std::error_code ignored;
    if (!fs::exists(state.file, ignored))
        return std::nullopt;
    try {
        FoundState found = unpacked(write::read_whole(state.file));
        if (found.facts != state.facts) {
            others = true;
            state.tell(fmt::format(
                "{}: is of another reference: {}. This one begins anew, and takes the file's place "
                "in {} s: interrupt it before then to keep the file",
                state.file.string(), difference(found.facts, state.facts), kLeaveOthers.count()));
            return std::nullopt;
        }
        if (glm::ivec2(found.partial.still.width, found.partial.still.height) != size)
            throw Error("its size is another");
        return std::move(found.partial);
    } catch (const Error& error) {
        state.tell(fmt::format("{}: is damaged ({}) and not used; the reference begins anew",
                               state.file.string(), error.what()));
        return std::nullopt;
    }
}

}  // namespace

ReferenceFacts reference_facts(const Scene& scene, const ReferenceOptions& options,
                               std::string_view version)
{
    const auto number = [](int bounces) {
        return bounces == kAllBounces ? std::string("all") : std::to_string(bounces);
    };
    ReferenceFacts facts{{"--tolerance", fmt::format("{}", options.tolerance)},
                         {"--aa", std::to_string(std::max(1, options.aa))},
                         {"--bounces", number(options.bounces)},
                         {"--surface-bounces", number(options.surface_bounces)},
                         {"--region", "the whole picture"},
                         {"the program's version", reference_version(version)}};
    if (const auto& region = options.region)
        facts["--region"] =
            fmt::format("{},{},{},{}", region->x, region->y, region->width, region->height);
    const nlohmann::json parts = nlohmann::json::parse(scene_by_content(scene));
    for (const auto& [name, value] : parts.items())
        facts[fmt::format("the scene's {}", name)] = value.dump();
    return facts;
}

fs::path reference_state_file(const fs::path& output)
{
    return output.string() + ".unfinished";
}

ResumedReference resume_reference(const Scene& scene, const ReferenceOptions& options,
                                  const ReferenceState& state)
{
    const glm::ivec2 size = options.region
                                ? glm::ivec2(options.region->width, options.region->height)
                                : glm::ivec2(scene.resolution);
    bool others = false, failed = false;
    const std::optional<PartialReference> begun = found_state(state, size, others);
    ResumedReference resumed;
    ReferenceOptions wanted = options;
    if (begun) {
        wanted.begun = &*begun;
        resumed.resumed = share_of(begun->finished);
        state.tell(fmt::format("{}: goes on from {:.1f} % of the pixels", state.file.string(),
                               100 * resumed.resumed));
    }
    double kept = resumed.resumed;
    const Clock::time_point begin = Clock::now();
    Clock::time_point next = begin + (others ? Clock::duration(kLeaveOthers) : kFirstKept);
    wanted.keep = [&](const ReferenceStill& still, const auto& finished, bool last) {
        const Clock::time_point now = Clock::now();
        if (now < next && !(last && !(others && now < begin + kLeaveOthers)))
            return;
        const std::vector<char> pixels = finished();
        const double share = share_of(pixels);
        if (share == 0)
            return;
        try {
            write::write_whole(state.file, packed(state.facts, still, pixels));
            kept = share;
        } catch (const Error& error) {
            if (!failed)
                state.tell(fmt::format("{}; what is done of the reference is not kept until then",
                                       error.what()));
            failed = true;
        }
        const Clock::time_point end = Clock::now();
        next = end + std::max<Clock::duration>(kKeptEvery, kKeepShare * (end - now));
    };
    try {
        resumed.still = render_reference(scene, wanted);
    } catch (ReferenceCancelled& cancelled) {
        cancelled.kept = kept;
        throw;
    }
    return resumed;
}

}  // namespace fumarole::study
