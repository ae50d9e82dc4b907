#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <fumarole/export.h>
#include <fumarole/scene.h>

namespace fumarole {

/// A part of one LiveScene, from its add() to its remove(), whatever becomes of the others. 0 is
/// none.
template <class Part> struct PartId {
    std::uint64_t number = 0;

    bool operator==(const PartId&) const = default;
};

using LightId = PartId<Light>;
using MediumId = PartId<Medium>;
using SurfaceId = PartId<Surface>;
using TransparentId = PartId<Transparent>;
using ProbeId = PartId<LightProbe>;

/// A scene whose parts come, change and go by ids. It is data, and draws nothing: give scene() to
/// Renderer::set_scene() when something has changed, which works out anew only what depends on
/// that.
class FUMAROLE_API LiveScene {
public:
    /// Its parts have ids in their order: lights(), media(), surfaces(), transparents() and
    /// probes().
    explicit LiveScene(Scene scene = {});

    LightId add(Light light);
    MediumId add(Medium medium);
    SurfaceId add(Surface surface);
    TransparentId add(Transparent transparent);
    ProbeId add(LightProbe probe);

    /// Puts another in a part's place: it may be of another type.
    /// @throws Error if the id is none of this scene's parts, or was removed
    void update(LightId id, Light light);
    void update(MediumId id, Medium medium);
    void update(SurfaceId id, Surface surface);
    void update(TransparentId id, Transparent transparent);
    void update(ProbeId id, LightProbe probe);

    /// @throws Error as update()
    void remove(LightId id);
    void remove(MediumId id);
    void remove(SurfaceId id);
    void remove(TransparentId id);
    void remove(ProbeId id);

    /// A part as it is now.
    /// @throws Error as update()
    [[nodiscard]] const Light& at(LightId id) const;
    [[nodiscard]] const Medium& at(MediumId id) const;
    [[nodiscard]] const Surface& at(SurfaceId id) const;
    [[nodiscard]] const Transparent& at(TransparentId id) const;
    [[nodiscard]] const LightProbe& at(ProbeId id) const;

    void set_world(World world);
    void set_time(double time);  ///< seconds: Scene::time

    /// Ids in the order of scene()'s parts.
    [[nodiscard]] std::span<const LightId> lights() const { return lights_; }
    [[nodiscard]] std::span<const MediumId> media() const { return media_; }
    [[nodiscard]] std::span<const SurfaceId> surfaces() const { return surfaces_; }
    [[nodiscard]] std::span<const TransparentId> transparents() const { return transparents_; }
    [[nodiscard]] std::span<const ProbeId> probes() const { return probes_; }
    [[nodiscard]] const Scene& scene() const { return scene_; }

private:
    Scene scene_;
    std::vector<LightId> lights_;
    std::vector<MediumId> media_;
    std::vector<SurfaceId> surfaces_;
    std::vector<TransparentId> transparents_;
    std::vector<ProbeId> probes_;
    std::uint64_t last_ = 0;  ///< number given out
};

}  // namespace fumarole
