//! The shader to pipelines: backdrop, surfaces, wide lines.

use super::chunk::{Segment, Vertex};
use super::target::{COLOUR_FORMAT, DEPTH_FORMAT, SAMPLES};
use ::wgpu::{CompareFunction, VertexBufferLayout, VertexStepMode};

/// One layout serves all: the globals are the only binding.
#[derive(Debug)]
pub(super) struct Pipelines {
    pub(super) bindings: ::wgpu::BindGroupLayout,
    pub(super) backdrop: ::wgpu::RenderPipeline,
    pub(super) surface: ::wgpu::RenderPipeline,
    pub(super) line: ::wgpu::RenderPipeline,
}

impl Pipelines {
    pub(super) fn new(device: &::wgpu::Device) -> Self {
        let bindings = device.create_bind_group_layout(&::wgpu::BindGroupLayoutDescriptor {
            label: Some("globals"),
            entries: &[::wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: ::wgpu::ShaderStages::VERTEX_FRAGMENT,
                ty: ::wgpu::BindingType::Buffer {
                    ty: ::wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
        let layout = device.create_pipeline_layout(&::wgpu::PipelineLayoutDescriptor {
            label: Some("trimtess"),
            bind_group_layouts: &[Some(&bindings)],
            immediate_size: 0,
        });
        let shader = device.create_shader_module(::wgpu::ShaderModuleDescriptor {
            label: Some("trimtess"),
            source: ::wgpu::ShaderSource::Wgsl(include_str!("shader.wgsl").into()),
        });
        let vertex = ::wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Unorm8x4];
        let vertex = VertexBufferLayout {
            array_stride: size_of::<Vertex>() as u64,
            step_mode: VertexStepMode::Vertex,
            attributes: &vertex,
        };
        let segment = ::wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Unorm8x4, 3 => Float32];
        let segment = VertexBufferLayout {
            array_stride: size_of::<Segment>() as u64,
            step_mode: VertexStepMode::Instance,
            attributes: &segment,
        };
        let pipeline = |name: &str, buffers: &[Option<VertexBufferLayout<'_>>], depth: CompareFunction| {
            device.create_render_pipeline(&::wgpu::RenderPipelineDescriptor {
                label: Some(name),
                layout: Some(&layout),
                vertex: ::wgpu::VertexState {
                    module: &shader,
                    entry_point: Some(&format!("{name}_vertex")),
                    compilation_options: ::wgpu::PipelineCompilationOptions::default(),
                    buffers,
                },
                primitive: ::wgpu::PrimitiveState::default(), // triangle list, counter-clockwise in front, nothing culled
                depth_stencil: Some(::wgpu::DepthStencilState {
                    format: DEPTH_FORMAT,
                    depth_write_enabled: Some(depth == CompareFunction::Greater),
                    depth_compare: Some(depth),
                    stencil: ::wgpu::StencilState::default(),
                    bias: ::wgpu::DepthBiasState::default(),
                }),
                multisample: ::wgpu::MultisampleState { count: SAMPLES, ..::wgpu::MultisampleState::default() },
                fragment: Some(::wgpu::FragmentState {
                    module: &shader,
                    entry_point: Some(&format!("{name}_fragment")),
                    compilation_options: ::wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(::wgpu::ColorTargetState {
                        blend: Some(::wgpu::BlendState::ALPHA_BLENDING), // only lines have alpha
                        ..COLOUR_FORMAT.into()
                    })],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        Self {
            backdrop: pipeline("backdrop", &[], CompareFunction::Always),
            surface: pipeline("surface", &[Some(vertex)], CompareFunction::Greater),
            line: pipeline("line", &[Some(segment)], CompareFunction::GreaterEqual),
            bindings,
        }
    }
}
