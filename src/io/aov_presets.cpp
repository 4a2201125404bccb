// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/aov_presets.h"

#include <array>

namespace stillray::io {
namespace {

/// Blender 2.8 to 4.x, then the names changed in Blender 5, then the single-channel letter of the
/// File Output node.
constexpr AovNameRow kBlender[] = {
    {Aov::kColour, "Noisy Image", "RGB"},
    {Aov::kColour, "Combined", "RGB"},
    {Aov::kColour, "Image", "RGB"},
    {Aov::kColour, "", "RGB"},
    {Aov::kResult, "Combined", "RGB"},
    {Aov::kResult, "Image", "RGB"},
    {Aov::kAlpha, "Combined", "A"},
    {Aov::kAlpha, "Image", "A"},
    {Aov::kAlpha, "", "A"},
    {Aov::kDepth, "Depth", "Z"},
    {Aov::kDepth, "Depth", "V"},
    {Aov::kNormal, "Normal", "XYZ"},
    {Aov::kMotion, "Vector", "XY"},
    {Aov::kNextMotion, "Vector", "ZW"},
    {Aov::kAlbedo, "DiffCol", "RGB"},
    {Aov::kAlbedo, "Diffuse Color", "RGB"},
    {Aov::kSpecularAlbedo, "GlossCol", "RGB"},
    {Aov::kSpecularAlbedo, "Glossy Color", "RGB"},
    {Aov::kTransmissionAlbedo, "TransCol", "RGB"},
    {Aov::kTransmissionAlbedo, "Transmission Color", "RGB"},
    {Aov::kFallbackAlbedo, "Denoising Albedo", "RGB"},
    {Aov::kFallbackNormal, "Denoising Normal", "XYZ"},
    {Aov::kSeenDepth, "Denoising Depth", "Z"},
    {Aov::kSeenDepth, "Denoising Depth", "V"},
    {Aov::kSeenNormal, "Denoising Normal", "XYZ"},
    {Aov::kSeenAlbedo, "Denoising Albedo", "RGB"},
    {Aov::kId, "IndexOB", "X"},
    {Aov::kId, "IndexOB", "V"},
    {Aov::kId, "Object Index", "X"},
    {Aov::kId, "Object Index", "V"},
    {Aov::kCryptomatte, "CryptoObject00", "r"},
    {Aov::kCryptomatte, "CryptoObject00", "R"},
    {Aov::kSamples, "Debug Sample Count", "X"},
    {Aov::kSamples, "Debug Sample Count", "V"},
    {Aov::kDirectDiffuse, "DiffDir", "RGB"},
    {Aov::kDirectDiffuse, "Diffuse Direct", "RGB"},
    {Aov::kIndirectDiffuse, "DiffInd", "RGB"},
    {Aov::kIndirectDiffuse, "Diffuse Indirect", "RGB"},
    {Aov::kDirectSpecular, "GlossDir", "RGB"},
    {Aov::kDirectSpecular, "Glossy Direct", "RGB"},
    {Aov::kIndirectSpecular, "GlossInd", "RGB"},
    {Aov::kIndirectSpecular, "Glossy Indirect", "RGB"},
    {Aov::kDirectTransmission, "TransDir", "RGB"},
    {Aov::kDirectTransmission, "Transmission Direct", "RGB"},
    {Aov::kIndirectTransmission, "TransInd", "RGB"},
    {Aov::kIndirectTransmission, "Transmission Indirect", "RGB"},
    {Aov::kDirectVolume, "VolumeDir", "RGB"},
    {Aov::kDirectVolume, "Volume Direct", "RGB"},
    {Aov::kIndirectVolume, "VolumeInd", "RGB"},
    {Aov::kIndirectVolume, "Volume Indirect", "RGB"},
    {Aov::kEmission, "Emit", "RGB"},
    {Aov::kEmission, "Emission", "RGB"},
    {Aov::kBackground, "Env", "RGB"},
    {Aov::kBackground, "Environment", "RGB"},
};

constexpr AovNameRow kStillray[] = {
    {Aov::kColour, "", "RGB"},
    {Aov::kDepth, "depth", "Z"},
    {Aov::kNormal, "normal", "XYZ"},
    {Aov::kPreviousNormal, "previous_normal", "XYZ"},
    {Aov::kMotion, "motion", "XY"},
    {Aov::kAlbedo, "albedo", "RGB"},
    {Aov::kSpecularAlbedo, "specular_albedo", "RGB"},
    {Aov::kTransmissionAlbedo, "transmission_albedo", "RGB"},
    {Aov::kReflectionDepth, "reflection_depth", "Z"},
    {Aov::kReflectionNormal, "reflection_normal", "XYZ"},
    {Aov::kReflectionAlbedo, "reflection_albedo", "RGB"},
    {Aov::kReflectionMotion, "reflection_motion", "XY"},
    {Aov::kReflectionId, "reflection_id", "X"},
    {Aov::kRefractionDepth, "refraction_depth", "Z"},
    {Aov::kRefractionNormal, "refraction_normal", "XYZ"},
    {Aov::kRefractionAlbedo, "refraction_albedo", "RGB"},
    {Aov::kRefractionMotion, "refraction_motion", "XY"},
    {Aov::kRefractionId, "refraction_id", "X"},
    {Aov::kId, "id", "X"},
    {Aov::kRoughness, "roughness", "X"},
    {Aov::kSamples, "samples", "X"},
    {Aov::kConfidence, "confidence", "X"},
    {Aov::kDirectDiffuse, "direct_diffuse", "RGB"},
    {Aov::kIndirectDiffuse, "indirect_diffuse", "RGB"},
    {Aov::kDirectSpecular, "direct_specular", "RGB"},
    {Aov::kIndirectSpecular, "indirect_specular", "RGB"},
    {Aov::kDirectTransmission, "direct_transmission", "RGB"},
    {Aov::kIndirectTransmission, "indirect_transmission", "RGB"},
    {Aov::kEmission, "emission", "RGB"},
    {Aov::kBackground, "background", "RGB"},
};

constexpr AovNameRow kArnold[] = {
    {Aov::kColour, "", "RGB"},
    {Aov::kColour, "RGBA", "RGB"},
    {Aov::kAlpha, "", "A"},
    {Aov::kDepth, "Z", "Z"},
    {Aov::kDepth, "", "Z"},
    {Aov::kNormal, "N", "XYZ"},
    {Aov::kNormal, "N", "RGB"},
    {Aov::kMotion, "motionvector", "RG"},
    {Aov::kMotion, "motionvector", "XY"},
    {Aov::kAlbedo, "diffuse_albedo", "RGB"},
    {Aov::kAlbedo, "albedo", "RGB"},
    {Aov::kSpecularAlbedo, "specular_albedo", "RGB"},
    {Aov::kTransmissionAlbedo, "transmission_albedo", "RGB"},
    {Aov::kFallbackAlbedo, "denoise_albedo_noisy", "RGB"},
    {Aov::kFallbackAlbedo, "albedo", "RGB"},
    {Aov::kDirectDiffuse, "diffuse_direct", "RGB"},
    {Aov::kIndirectDiffuse, "diffuse_indirect", "RGB"},
    {Aov::kDirectSpecular, "specular_direct", "RGB"},
    {Aov::kIndirectSpecular, "specular_indirect", "RGB"},
    {Aov::kDirectTransmission, "transmission_direct", "RGB"},
    {Aov::kIndirectTransmission, "transmission_indirect", "RGB"},
    {Aov::kDirectVolume, "volume_direct", "RGB"},
    {Aov::kIndirectVolume, "volume_indirect", "RGB"},
    {Aov::kEmission, "emission", "RGB"},
    {Aov::kBackground, "background", "RGB"},
};

constexpr AovNameRow kRenderMan[] = {
    {Aov::kColour, "Ci", "RGB"},
    {Aov::kColour, "Ci", "rgb"},
    {Aov::kColour, "", "RGB"},
    {Aov::kAlpha, "", "A"},
    {Aov::kDepth, "z", "Z"},
    {Aov::kDepth, "", "z"},
    {Aov::kDepth, "", "Z"},
    {Aov::kNormal, "Nn", "XYZ"},
    {Aov::kNormal, "Nn", "xyz"},
    {Aov::kNormal, "Nn", "RGB"},
    {Aov::kNormal, "normal", "XYZ"},
    {Aov::kNormal, "normal", "RGB"},
    {Aov::kMotion, "motionBack", "XY"},
    {Aov::kMotion, "motionBack", "xy"},
    {Aov::kMotion, "motionBack", "RG"},
    {Aov::kNextMotion, "motionFore", "XY"},
    {Aov::kNextMotion, "motionFore", "xy"},
    {Aov::kNextMotion, "motionFore", "RG"},
    {Aov::kAlbedo, "albedo", "RGB"},
    {Aov::kAlbedo, "albedo", "rgb"},
    {Aov::kFallbackAlbedo, "albedo", "RGB"},
    {Aov::kFallbackAlbedo, "albedo", "rgb"},
    {Aov::kDirectDiffuse, "directDiffuse", "RGB"},
    {Aov::kDirectDiffuse, "directDiffuse", "rgb"},
    {Aov::kIndirectDiffuse, "indirectDiffuse", "RGB"},
    {Aov::kIndirectDiffuse, "indirectDiffuse", "rgb"},
    {Aov::kDirectSpecular, "directSpecular", "RGB"},
    {Aov::kDirectSpecular, "directSpecular", "rgb"},
    {Aov::kIndirectSpecular, "indirectSpecular", "RGB"},
    {Aov::kIndirectSpecular, "indirectSpecular", "rgb"},
    {Aov::kIndirectTransmission, "transmissive", "RGB"},
    {Aov::kIndirectTransmission, "transmissive", "rgb"},
    {Aov::kEmission, "emissive", "RGB"},
    {Aov::kEmission, "emissive", "rgb"},
};

constexpr AovNameRow kVRay[] = {
    {Aov::kColour, "", "RGB"},
    {Aov::kAlpha, "", "A"},
    {Aov::kDepth, "VRayZDepth", "Z"},
    {Aov::kDepth, "VRayZDepth", "R"},
    {Aov::kDepth, "zDepth", "R"},
    {Aov::kDepth, "", "Z"},
    {Aov::kNormal, "VRayNormals", "XYZ"},
    {Aov::kNormal, "VRayNormals", "RGB"},
    {Aov::kNormal, "normals", "XYZ"},
    {Aov::kNormal, "normals", "RGB"},
    {Aov::kMotion, "VRayVelocity", "RG"},
    {Aov::kMotion, "VRayVelocity", "XY"},
    {Aov::kMotion, "velocity", "RG"},
    {Aov::kMotion, "velocity", "XY"},
    {Aov::kAlbedo, "VRayDiffuseFilter", "RGB"},
    {Aov::kAlbedo, "diffuseFilter", "RGB"},
    {Aov::kFallbackAlbedo, "VRayDiffuseFilter", "RGB"},
    {Aov::kFallbackAlbedo, "diffuseFilter", "RGB"},
    {Aov::kDirectDiffuse, "VRayLighting", "RGB"},
    {Aov::kDirectDiffuse, "lighting", "RGB"},
    {Aov::kIndirectDiffuse, "VRayGlobalIllumination", "RGB"},
    {Aov::kIndirectDiffuse, "GI", "RGB"},
    {Aov::kDirectSpecular, "VRaySpecular", "RGB"},
    {Aov::kDirectSpecular, "specular", "RGB"},
    {Aov::kIndirectSpecular, "VRayReflection", "RGB"},
    {Aov::kIndirectSpecular, "reflect", "RGB"},
    {Aov::kIndirectTransmission, "VRayRefraction", "RGB"},
    {Aov::kIndirectTransmission, "refract", "RGB"},
    {Aov::kEmission, "VRaySelfIllumination", "RGB"},
    {Aov::kEmission, "selfIllum", "RGB"},
    {Aov::kBackground, "VRayBackground", "RGB"},
    {Aov::kBackground, "background", "RGB"},
};

constexpr MotionConvention kStillrayMotion;
constexpr MotionConvention kStillrayNextMotion = {.direction = MotionDirection::kToNext};
constexpr MotionConvention kBlenderMotion = {.y_up = true};
constexpr MotionConvention kForwardMotion = {.direction = MotionDirection::kToNext, .y_up = true};
/// Blender's ZW is the position in this frame minus that in the next frame.
constexpr MotionConvention kBlenderNextMotion = {.direction = MotionDirection::kFromNext,
                                                 .y_up = true};
constexpr DepthConvention kLinearDepth;
constexpr NormalConvention kWorldNormal;

constexpr std::array<AovPreset, 5> kPresets = {{
    {"blender", kBlender, kBlenderMotion, kBlenderNextMotion, kLinearDepth, kWorldNormal, true,
     true},
    {"stillray", kStillray, kStillrayMotion, kStillrayNextMotion, kLinearDepth, kWorldNormal, false,
     false},
    {"arnold", kArnold, kForwardMotion, kForwardMotion, kLinearDepth, kWorldNormal, false, true},
    {"renderman", kRenderMan, kBlenderMotion, kForwardMotion, kLinearDepth, kWorldNormal, false,
     true},
    {"vray", kVRay, kForwardMotion, kForwardMotion, kLinearDepth, kWorldNormal, false, true},
}};

}  // namespace

std::span<const AovPreset> AovPresets() {
  return kPresets;
}

}  // namespace stillray::io
