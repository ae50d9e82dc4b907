#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gl/texture.h"
#include "light/fire_light.h"
#include "light/radiance_field.h"
#include "light/world_plan.h"

namespace fumarole::light {

/// Why a scene's plan is as it is; empty: it is not asked.
struct PlanReasons {
    const std::string& sky;     ///< SkySeen's
    const std::string& turns;   ///< SurfaceTurns'
    const std::string& orders;  ///< plan_world()'s
};

/// What each order brought, or all of them where they started from other light, as the field that
/// was filled last has it. Waits for the GPU.
std::string describe_orders(const RadianceField& field, bool in_all);

/// Light that is not direct, as it was filled by one plan.
struct WorldLight {
    WorldPlan plan;
    /// Coefficients of the world's light. Where there is a field they are kept from the first
    /// time on that lights change, and not what dims it: a scene that stays as it is has no use
    /// for them.
    gl::Texture coefficients;
    gl::Texture field_coefficients;  ///< coefficients of all light that is not direct
    gl::Texture of_media;            ///< of it what media scatter and emit, for WorldPlan::amid
    gl::Texture bounced;             ///< light that surfaces send on, at their nodes
    std::vector<gl::Texture>
        bounced_means;  ///< its mean at the nodes after each of the turns that were noted
    int turns_after_noted = 0;
    gl::Texture walls;        ///< walls between the surfaces' nodes
    gl::Texture sights;       ///< how far each of these sees
    gl::Texture world_walls;  ///< walls between the media's nodes, where surfaces send light on
    gl::Texture on_surfaces, on_surfaces_dimmed;  ///< coefficients of the world's light
    /// What media emit, on surfaces; null: nothing. What is being filled has that which is
    /// shown, where it is the same.
    std::shared_ptr<FireLight> fire;
    bool goes_on = false;      ///< orders in the media started from what was shown before
    std::optional<double> ms;  ///< time that filling it took [ms], if it was measured

    /// Coefficients of all that reaches the media but what is direct.
    [[nodiscard]] const gl::Texture& in_media() const
    {
        return field_coefficients ? field_coefficients : coefficients;
    }

    /// What is kept, at what size, and what it took to fill: a line each. Waits for the GPU.
    [[nodiscard]] std::vector<std::string> describe(const PlanReasons& why) const;
};

}  // namespace fumarole::light
