#include "study/reference_cache.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <optional>
#include <variant>

#include "study/reference_state.h"
#include <fumarole/asset/scene_file.h>
#include <fumarole/errors.h>
#include <fumarole/write/image_writer.h>

namespace fumarole::study {

namespace {

namespace fs = std::filesystem;

/// Raised whenever the reference gives another answer to the same question.
constexpr int kReferenceRevision = 5;

class Fnv1a {
public:
    void add(std::string_view bytes)
    {
        for (const char byte : bytes) {
            hash_ ^= static_cast<unsigned char>(byte);
            hash_ *= 0x100000001b3u;
        }
    }
    [[nodiscard]] std::string hex() const { return fmt::format("{:016x}", hash_); }

private:
    std::uint64_t hash_ = 0xcbf29ce484222325u;
};

/// A file's name gives way to its content.
void name_by_content(std::string& file)
{
    if (!file.empty())
        file = fmt::format("/{}", file_hash(file));
}

/// The pictures of a reference and how their channels are called in a file.
struct Layer {
    std::vector<float> ReferenceStill::*pixels;
    std::vector<std::string> channels;
};

const std::vector<Layer>& layers()
{
    static const std::vector<Layer> table{
        {&ReferenceStill::composite, {"R", "G", "B"}},
        {&ReferenceStill::scattering, {"scattering.R", "scattering.G", "scattering.B"}},
        {&ReferenceStill::transmittance, {"transmittance.R", "transmittance.G", "transmittance.B"}},
        {&ReferenceStill::surface, {"surface.R", "surface.G", "surface.B"}},
        {&ReferenceStill::surface_lit, {"surface_lit.R", "surface_lit.G", "surface_lit.B"}},
        {&ReferenceStill::depth, {"depth.Z"}},
        {&ReferenceStill::error, {"error.Y"}},
        {&ReferenceStill::noise, {"noise.R", "noise.G", "noise.B"}},
        {&ReferenceStill::scattering_noise,
         {"scattering_noise.R", "scattering_noise.G", "scattering_noise.B"}}};
    return table;
}

Image to_image(const ReferenceStill& still)
{
    Image image;
    image.width = still.width;
    image.height = still.height;
    for (const Layer& layer : layers())
        image.channels.insert(image.channels.end(), layer.channels.begin(), layer.channels.end());
    const std::size_t pixels = still.depth.size();
    image.pixels.reserve(pixels * image.channels.size());
    for (std::size_t i = 0; i < pixels; ++i)
        for (const Layer& layer : layers())
            for (std::size_t c = 0; c < layer.channels.size(); ++c)
                image.pixels.push_back((still.*layer.pixels)[i * layer.channels.size() + c]);
    return image;
}

std::optional<ReferenceStill> read(const fs::path& file, glm::uvec2 size)
{
    std::error_code ignored;
    if (!fs::is_regular_file(file, ignored))
        return std::nullopt;
    try {
        ReferenceStill still;
        for (const Layer& layer : layers()) {
            Image image = write::read_exr(file, layer.channels);
            still.width = image.width;
            still.height = image.height;
            still.*layer.pixels = std::move(image.pixels);
        }
        if (glm::uvec2(still.width, still.height) != size)
            return std::nullopt;
        return still;
    } catch (const Error&) {
        return std::nullopt;  // torn or of another making
    }
}

}  // namespace

std::string text_hash(std::string_view text)
{
    Fnv1a hash;
    hash.add(text);
    return hash.hex();
}

std::string file_hash(const fs::path& file)
{
    std::error_code error;
    if (fs::is_directory(file, error))
        throw Error(fmt::format("{}: is a folder; name a file", file.string()));
    errno = 0;
    std::ifstream stream(file, std::ios::binary);
    Fnv1a hash;
    std::vector<char> part(1 << 20);
    while (stream) {
        stream.read(part.data(), static_cast<std::streamsize>(part.size()));
        hash.add({part.data(), static_cast<std::size_t>(stream.gcount())});
    }
    if (!stream.eof())
        throw Error(fmt::format("{}: can't be read: {}", file.string(),
                                std::strerror(errno != 0 ? errno : EIO)));
    return hash.hex();
}

std::string scene_by_content(const Scene& scene)
{
    Scene named = scene;
    for (Medium& medium : named.media)
        if (auto* grid = std::get_if<GridMedium>(&medium))
            name_by_content(grid->file);
    for (Surface& surface : named.surfaces)
        if (auto* mesh = std::get_if<MeshSurface>(&surface))
            name_by_content(mesh->file);
    name_by_content(named.world.environment_file);
    return asset::scene_to_json(named, "/");
}

std::string reference_version(std::string_view version)
{
    return fmt::format("{} {}", version, kReferenceRevision);
}

std::string reference_key(const Scene& scene, const ReferenceOptions& options,
                          std::string_view version)
{
    std::string text = fmt::format("{}\n{} {} {} {}", scene_by_content(scene), options.tolerance,
                                   options.aa, options.bounces, reference_version(version));
    // Said where there are any: what was kept before they were known stays what it is.
    if (options.surface_bounces != 0)
        text += fmt::format(" surfaces {}", options.surface_bounces);
    return text_hash(text);
}

fs::path kept_reference_file(const fs::path& folder, std::string_view key)
{
    return folder / fmt::format("reference_{}.exr", key);
}

KeptReference keep_reference(const Scene& scene, const ReferenceOptions& options,
                             const fs::path& folder, std::string_view version,
                             const std::function<void(const std::string&)>& tell)
{
    KeptReference kept;
    kept.key = reference_key(scene, options, version);
    kept.file = kept_reference_file(folder, kept.key);
    if (std::optional<ReferenceStill> still = read(kept.file, scene.resolution)) {
        kept.still = std::move(*still);
        kept.reused = true;
        return kept;
    }
    const auto begin = std::chrono::steady_clock::now();
    const ReferenceState state{reference_state_file(kept.file), {{"the key", kept.key}}, tell};
    kept.still = resume_reference(scene, options, state).still;
    kept.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    write::write_exr(to_image(kept.still), kept.file);
    std::error_code ignored;
    fs::remove(state.file, ignored);
    return kept;
}

}  // namespace fumarole::study
