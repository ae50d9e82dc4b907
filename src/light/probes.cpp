#include "light/probes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

#include <fumarole/errors.h>

namespace fumarole::light {

namespace {

static_assert(static_cast<int>(LightProbe::Parallax::sphere) == shared::kParallaxSphere &&
              static_cast<int>(LightProbe::Parallax::box) == shared::kParallaxBox);

bool is_glossy(const Surface& surface)
{
    return std::visit([](const auto& one) { return one.gloss.has_value(); }, surface);
}

/// An octahedral map that has about the texels of a picture all around of so many.
int probe_map_size(int texels_around)
{
    constexpr int kLeast = 64, kMost = 1024;
    return std::clamp(static_cast<int>(std::bit_ceil(static_cast<unsigned>(texels_around) / 2)),
                      kLeast, kMost);
}

}  // namespace

glm::dmat4 probe_view_from_world(glm::dvec3 position, int face)
{
    const int a = face / 2;
    const double side = face % 2 == 0 ? 1 : -1;
    glm::dvec3 forward(0), up(0);
    forward[a] = side;
    up[(a + 2) % 3] = 1;
    const glm::dvec3 right = glm::cross(forward, up);
    glm::dmat4 view(glm::transpose(glm::dmat3(right, up, -forward)));
    view[3] = glm::dvec4(glm::dmat3(view) * -position, 1);
    return view;
}

glm::dmat4 probe_clip_from_view(double near)
{
    glm::dmat4 clip(0.0);
    clip[0][0] = clip[1][1] = 1;
    clip[2][3] = -1;
    clip[3][2] = near;
    return clip;
}

void Probes::set(const Scene& scene, const SceneSettings& settings, const LightSet& lights,
                 const medium::MediaSet& media)
{
    set_world(scene, lights);
    set_placed(scene, settings, media);
}

void Probes::set_world(const Scene& scene, const LightSet& lights)
{
    const World& world = scene.world;
    if (world.environment == nullptr ||
        std::none_of(scene.surfaces.begin(), scene.surfaces.end(), is_glossy)) {
        world_ = {};
        world_source_ = nullptr;
        return;
    }
    if (world_source_ == world.environment && world_scale_ == world.environment_scale)
        return;
    const ProbeLayout layout(probe_map_size(world.environment->width));
    world_ = filter_.make_maps("world probe", layout, 1);
    filter_.filter_environment(lights.environment(), world_, layout, 0);
    world_source_ = world.environment;
    world_scale_ = world.environment_scale;
    params_.world = layout.params();
}

std::vector<LightProbe> Probes::wanted(const Scene& scene, const SceneSettings& settings,
                                       const medium::MediaSet& media)
{
    if (settings.probes == SceneSettings::Probes::off || scene.surfaces.empty() ||
        !scene.probes.empty()) {
        own_place_.reset();
        return settings.probes == SceneSettings::Probes::off || scene.surfaces.empty()
                   ? std::vector<LightProbe>{}
                   : scene.probes;
    }
    // Media that move or change leave it where it is: frames of a sequence show one.
    if (!own_place_ || seen_.surfaces != scene.surfaces || seen_.media.size() != scene.media.size())
        own_place_ = place_probes(scene, media);
    return own_place_->probes;
}

void Probes::set_placed(const Scene& scene, const SceneSettings& settings,
                        const medium::MediaSet& media)
{
    const std::vector<LightProbe> wanted = this->wanted(scene, settings, media);
    const bool same_surfaces = seen_.surfaces == scene.surfaces;
    Scene sees = scene;
    sees.probes.clear();
    sees.transparents = casters_of(scene.transparents);  // others are seen by the eye alone
    const bool same = same_content(sees, seen_);
    seen_ = std::move(sees);
    // Those that are placed by themselves are for what is glossy: their few places say little of
    // others' dark corners.
    diffuse_ = scene.media.empty() && !own_place_;
    if (wanted.size() > MAX_PROBES)
        throw Error(fmt::format("the scene has {} probes, and {} is the most at once; leave some "
                                "out",
                                wanted.size(), MAX_PROBES));
    std::vector<Surface> drawn = scene.surfaces;
    std::erase_if(drawn, [](const Surface& surface) {
        const auto* mesh = std::get_if<MeshSurface>(&surface);
        return mesh != nullptr && mesh->mesh == nullptr;
    });
    int size = 0;
    for (const LightProbe& probe : wanted)
        size = std::max(size, probe_map_size(4 * probe.size));
    std::vector<Placed> old = std::exchange(placed_, {});
    const bool fits = layout_ && size == layout_->maps().front().size;
    if (!fits)
        old.clear();
    const bool are_as_many = old.size() == wanted.size();
    // Those that are there yet, at whatever place of the list, keep what they have seen.
    placed_.resize(wanted.size());
    std::vector<std::size_t> moved;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        const LightProbe& probe = wanted[i];
        const auto before = std::find_if(old.begin(), old.end(), [&](const Placed& one) {
            return one.probe.position == probe.position && one.probe.size == probe.size;
        });
        if (before == old.end()) {
            moved.push_back(i);
            continue;
        }
        placed_[i] = std::move(*before);
        old.erase(before);
        if (!same && !placed_[i].glimpse.empty())
            placed_[i].doubted = true;
        else if (!same)
            placed_[i].turns = 0;
        if (!same_surfaces)
            placed_[i].unseen = unseen_by(probe, drawn);
        placed_[i].probe = probe;
    }
    // One that is dragged shows what it saw where it was until it is captured anew, and that fades
    // in over it.
    for (std::size_t k = 0; k < moved.size(); ++k) {
        Placed& placed = placed_[moved[k]];
        if (are_as_many && same_surfaces)
            placed = std::move(old[k]);
        placed.turns = 0;
        placed.doubted = placed.found_same = false;
        placed.glimpse.clear();
        placed.probe = wanted[moved[k]];
        placed.unseen = unseen_by(placed.probe, drawn);
    }
    if (wanted.empty()) {
        maps_ = {};
        faces_.clear();
        layout_.reset();
        return;
    }
    if (!fits) {
        faces_.clear();
        maps_ = {};
        layout_.emplace(size);
        params_.placed = layout_->params();
    }
    make_room();
}

Probes::EvenFog Probes::even_fog_at(const std::vector<Medium>& media, glm::dvec3 p)
{
    EvenFog fog;
    for (const Medium& medium : media) {
        const auto* box = std::get_if<BoxMedium>(&medium);
        if (box == nullptr || !std::holds_alternative<HomogeneousProfile>(box->profile) ||
            !glm::all(glm::greaterThanEqual(p, box->min)) ||
            !glm::all(glm::lessThanEqual(p, box->max)))
            continue;
        const double scattering = glm::dot(glm::dvec3(box->sigma_s), glm::dvec3(1)) / 3;
        fog.extinction += scattering + glm::dot(glm::dvec3(box->sigma_a), glm::dvec3(1)) / 3;
        fog.scattering += scattering;
    }
    return fog;
}

/// Of each probe what it sees and what it has seen before.
void Probes::make_room()
{
    if (maps_ && maps_.size().z >= 2 * count())
        return;
    const gl::Texture old =
        std::exchange(maps_, filter_.make_maps("probes", *layout_, 2 * count()));
    if (!old)
        return;
    const glm::ivec2 size = layout_->size();
    device_->MemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    for (int layer = 0; layer < old.size().z; ++layer)
        device_->CopyImageSubData(old.id(), GL_TEXTURE_2D_ARRAY, 0, 0, 0, layer, maps_.id(),
                                  GL_TEXTURE_2D_ARRAY, 0, 0, 0, layer, size.x, size.y, 1);
}

int Probes::free_pair() const
{
    int first = 0;
    const auto is_taken = [&](const Placed& one) {
        return one.layer == first || one.layer == first + 1;
    };
    while (std::any_of(placed_.begin(), placed_.end(), is_taken))
        first += 2;
    return first;
}

void Probes::clear()
{
    world_ = {};
    world_source_ = nullptr;
    placed_.clear();
    maps_ = {};
    faces_.clear();
    layout_.reset();
    seen_ = {};
    own_place_.reset();
}

int Probes::ready() const
{
    return static_cast<int>(std::count_if(placed_.begin(), placed_.end(),
                                          [](const Placed& one) { return one.layer >= 0; }));
}

std::optional<int> Probes::next(bool anew) const
{
    const auto least =
        std::min_element(placed_.begin(), placed_.end(), [](const Placed& a, const Placed& b) {
            return std::pair(a.layer >= 0, a.turns) < std::pair(b.layer >= 0, b.turns);
        });
    if (least == placed_.end() || least->turns >= kTurns || (least->layer >= 0 && !anew))
        return {};
    return static_cast<int>(least - placed_.begin());
}

std::optional<int> Probes::doubted() const
{
    const auto at =
        std::find_if(placed_.begin(), placed_.end(), [](const Placed& one) { return one.doubted; });
    if (at == placed_.end())
        return {};
    return static_cast<int>(at - placed_.begin());
}

std::optional<int> Probes::unglimpsed() const
{
    const auto at = std::find_if(placed_.begin(), placed_.end(),
                                 [](const Placed& one) { return one.glimpse.empty(); });
    if (at == placed_.end() || next(true) || doubted())
        return {};
    return static_cast<int>(at - placed_.begin());
}

void Probes::take_glimpse(int i, std::vector<float> rgb)
{
    // Nothing jitters: what is the same is drawn the same, to rounding.
    constexpr float kSame = 1e-4f;  // of the mean
    Placed& placed = placed_[static_cast<std::size_t>(i)];
    if (!std::exchange(placed.doubted, false)) {
        placed.glimpse = std::move(rgb);
        return;
    }
    const float mean =
        std::accumulate(rgb.begin(), rgb.end(), 0.0f) / static_cast<float>(rgb.size());
    const bool same = std::equal(
        rgb.begin(), rgb.end(), placed.glimpse.begin(), placed.glimpse.end(),
        [&](float a, float b) { return std::abs(a - b) <= kSame * std::max(mean, 1e-20f); });
    placed.found_same = same;
    if (same)
        return;
    placed.turns = 0;
    placed.glimpse.clear();
}

void Probes::believe_none()
{
    for (Placed& placed : placed_)
        if (std::exchange(placed.doubted, false)) {
            placed.turns = 0;
            placed.glimpse.clear();
        }
}

const gl::Texture& Probes::faces(int size)
{
    gl::Texture& six = faces_[size];
    if (!six)
        six = gl::Texture::make_2d_array(device_, "probe's faces", {size, size, 6}, GL_RGBA32F,
                                         gl::Filter::linear);
    return six;
}

void Probes::take_face(int face, const gl::Texture& color)
{
    const int size = face_size_ = color.size().x;
    const gl::Texture& six = faces(size);
    constexpr unsigned kGroup = 8;
    const unsigned groups = (static_cast<unsigned>(size) + kGroup - 1) / kGroup;
    device_->UseProgram(programs_.get({"probe/face.comp"}, {}).id());
    color.bind(PROBE_SOURCE_UNIT);
    device_->BindImageTexture(0, six.id(), 0, GL_FALSE, face, GL_WRITE_ONLY, GL_RGBA32F);
    device_->DispatchCompute(groups, groups, 1);
    device_->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

void Probes::finish(int i, const gl::Stopwatch& watch)
{
    Placed& placed = placed_[static_cast<std::size_t>(i)];
    // What is still fading in is replaced where it is: to begin anew from it would be a leap.
    if (placed.layer < 0 || placed.newness >= 1) {
        placed.old_layer = placed.layer;
        placed.old_seen_from = placed.seen_from;
        placed.layer = placed.layer < 0 ? free_pair() : placed.layer ^ 1;
        placed.newness = 0;
        placed.two_turns = placed.turns > 0;
    }
    filter_.filter_faces(faces(face_size_), maps_, *layout_, placed.layer);
    placed.seen_from = placed.probe.position;
    placed.fog = even_fog_at(seen_.media, placed.seen_from);
    placed.captured_at = std::chrono::steady_clock::now();
    placed.capture_ms = watch.ms();
    ++placed.captures;
    ++placed.turns;
    ++captures_;
    // Those that saw nothing new may see in mirrors what others have newly seen.
    if (!next(true))
        for (Placed& other : placed_)
            other.doubted |= std::exchange(other.found_same, false);
}

bool Probes::have_two_turns() const
{
    return std::all_of(placed_.begin(), placed_.end(), [](const Placed& one) {
        return one.turns >= kTurns && one.old_layer >= 0 && one.two_turns;
    });
}

void Probes::prepare()
{
    for (const Placed& placed : placed_)
        face_size_ = faces(placed.probe.size).size().x;
    const gl::Texture scratch = filter_.make_maps("prepared probe", *layout_, 1);
    filter_.filter_faces(faces(face_size_), scratch, *layout_, 0);
}

std::vector<ProbeState> Probes::states() const
{
    const auto now = std::chrono::steady_clock::now();
    std::vector<ProbeState> all;
    for (const Placed& placed : placed_) {
        ProbeState state{.probe = placed.probe,
                         .by_itself = own_place_.has_value(),
                         .captures = placed.captures};
        if (placed.captures > 0) {
            state.seconds_ago = std::chrono::duration<double>(now - placed.captured_at).count();
            state.capture_ms = placed.capture_ms;
        }
        all.push_back(state);
    }
    return all;
}

void Probes::fade(bool at_once)
{
    constexpr float kFrames = 8;
    for (Placed& placed : placed_)
        placed.newness = at_once ? 1 : std::min(1.0f, placed.newness + 1 / kFrames);
}

void Probes::bind(glm::dvec3 eye)
{
    if (!world_ && placed_.empty())
        return;
    params_.count = 0;
    for (const Placed& placed : placed_) {
        if (placed.layer < 0)
            continue;
        const LightProbe& probe = placed.probe;
        const bool has_old = placed.old_layer >= 0;
        const float newness = !capturing_                              ? placed.newness
                              : *capturing_ == Shown::before_last_turn ? 0.0f
                                                                       : 1.0f;
        params_.probes[params_.count++] = {
            glm::vec3(probe.position - eye),
            static_cast<float>(probe.radius),
            glm::vec3(probe.parallax_min - eye),
            static_cast<float>(probe.radius * probe.falloff),
            glm::vec3(probe.parallax_max - eye),
            static_cast<int>(probe.parallax),
            glm::vec3(placed.seen_from - eye),
            placed.layer,
            glm::vec3(placed.old_seen_from - eye),
            has_old ? placed.old_layer : placed.layer,
            has_old ? newness : 1.0f,
            has_old ? 1.0f : newness,
            static_cast<float>(placed.fog.extinction),
            static_cast<float>(placed.fog.scattering / std::max(placed.fog.extinction, 1e-30))};
    }
    block_.write(params_);
    device_->BindBufferBase(GL_UNIFORM_BUFFER, PROBES_BLOCK, block_.id());
    world_.bind(WORLD_PROBE_UNIT);
    maps_.bind(PROBES_UNIT);
}

gl::Defines Probes::defines() const
{
    if ((ready() == 0 || capturing_ == Shown::first_turn) && !preparing_)
        return {};
    gl::Defines defines{{"kProbes", ""}};
    if (diffuse_)
        defines.emplace_back("kProbeIrradiance", "");
    return defines;
}

std::vector<std::string> Probes::describe() const
{
    std::vector<std::string> lines;
    if (world_)
        lines.push_back(
            fmt::format("world probe: the map by roughness, {} texels along an edge, for "
                        "glossy surfaces",
                        probe_map_size(world_source_->width)));
    if (own_place_)
        lines.push_back(own_place_->why);
    if (!placed_.empty())
        lines.push_back(
            fmt::format("probes: {} of {} ready, {} texels along an edge of the first "
                        "of {} maps{}",
                        ready(), count(), layout_->maps().front().size, layout_->maps().size(),
                        diffuse_ ? "; they light rough surfaces too, as no medium does" : ""));
    return lines;
}

}  // namespace fumarole::light
