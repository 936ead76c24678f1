//! A frame to binary glTF 2.0: metres, +Y up, one mesh per part, one node per instance, one primitive per colour.
//!
//! Positions are single precision relative to the centre of the part's bounding box, which the node's translation adds
//! back, so parts far from the origin keep their precision. Where one translation has too few digits for the tolerance,
//! nested nodes add up to the place. Each vertex stores the index of its face in `_FEATURE_ID_0`
//! (EXT_mesh_features). B-rep edges are lines whose points store the index of the edge. Each node may have coarser
//! nodes (MSFT_lod), and the share of the screen below which each replaces it.

use super::format::GlbOptions;
use super::glb_buffers::{Buffers, Stream};
use super::glb_numbers::{Group, Numbers, bytes, numbers};
use super::making::{Making, MeshLevel, Pieces, SaveError, counted};
use super::node_place::{NodePlace, PointNumbers, Turn, groups};
use super::placed::{DEFAULT_COLOUR, instance_name, linear};
use super::rounding::{Rounding, RoundingCount};
use crate::control::Call;
use crate::mesh::{BatchView, EdgeLine, ScenePart};
use crate::model::Colour;
use glam::Vec3;
use gltf_json::material::{AlphaMode, PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::scene::UnitQuaternion;
use gltf_json::validation::Checked::Valid;
use gltf_json::{Accessor, Asset, Index, Material, Mesh, Node, Root, Scene, Value};
use std::collections::{BTreeMap, HashMap};
use std::f64::consts::FRAC_PI_4;
use std::io::{self, Write};

/// Pixels of the screen on which a level is drawn as soon as its chord tolerance is a pixel or less.
const SCREEN: f64 = 1920.0 * 1080.0;

/// The nodes of the coarser levels of a node, and when they are drawn.
#[derive(Debug, Default)]
struct Detail {
    /// Indices of nodes, finest first.
    nodes: Vec<u32>,
    /// The share of the screen below which each node replaces the level before it.
    shares: Vec<f32>,
}

impl Detail {
    /// Adds a node with a mesh of this chord tolerance, for a part whose sphere has this diameter, both millimetres.
    fn add(&mut self, node: u32, diameter: f64, chord: f64) {
        let pixels = diameter / chord;
        self.nodes.push(node);
        self.shares.push((FRAC_PI_4 * pixels * pixels / SCREEN).min(1.0) as f32);
    }

    /// The node's extension, if there are levels.
    fn extension(&self) -> Option<String> {
        (!self.nodes.is_empty()).then(|| format!(r#""MSFT_lod":{{"ids":{:?}}}"#, self.nodes))
    }

    /// What goes with the extension.
    fn extra(&self) -> Option<String> {
        let shares = self.shares.iter().map(|share| format!("{share},"));
        (!self.nodes.is_empty()).then(|| format!(r#""MSFT_screencoverage":[{}0]"#, shares.collect::<String>()))
    }
}

/// Rotation from +Z up to +Y up, by columns.
const Y_UP: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
/// The colour of B-rep edges.
const EDGE_COLOUR: Colour = [0.08, 0.09, 0.1, 1.0];

/// Number of tiles that [`glb`] makes the bytes of.
pub(super) fn tiles(levels: &[MeshLevel<'_>]) -> usize {
    let of_level = |MeshLevel { frame, .. }: &MeshLevel<'_>| {
        let parts = frame.scene.parts.len();
        frame.batches.iter().filter(|batch| batch.part.index() < parts).count()
    };
    levels.iter().map(of_level).sum()
}

/// Makes a file with levels of detail, finest first, and measures what rounding costs in each. A node whose translation
/// is rounded by more than half of `most` millimetres is put into others, and the translations add up to the place.
///
/// # Errors
/// If a number overflows single precision, rounding moves a vertex by more than `most`, or there are more than 4 GiB.
/// When cancelled.
pub(super) fn glb(
    making: &Making<'_>,
    levels: &[MeshLevel<'_>],
    (options, most): (GlbOptions, f64),
) -> Result<(Pieces, Vec<Rounding>), SaveError> {
    let (glb, roundings) = Glb::of(making, levels, (options, most))?;
    roundings.iter().try_for_each(|rounding| rounding.within(most))?;
    Ok((glb.finish(making)?, roundings))
}

/// Batches and edge lines of a part.
type PartRows<'a> = (Vec<&'a BatchView<'a>>, Vec<&'a EdgeLine>);

/// Whether two meshes of a part are the same in a file. No, once cancelled.
fn is_same(call: Call<'_>, (batches, lines): &PartRows<'_>, (other_batches, other_lines): &PartRows<'_>) -> bool {
    let same_batch = |(a, b): (&&BatchView<'_>, &&BatchView<'_>)| {
        !call.is_cancelled()
            && (a.face, a.mesh.positions, a.mesh.normals) == (b.face, b.mesh.positions, b.mesh.normals)
            && a.mesh.triangles.iter().eq(b.mesh.triangles.iter())
    };
    let same_line = |(a, b): (&&EdgeLine, &&EdgeLine)| (a.edge, &a.points) == (b.edge, &b.points);
    (batches.len(), lines.len()) == (other_batches.len(), other_lines.len())
        && batches.iter().zip(other_batches).all(same_batch)
        && lines.iter().zip(other_lines).all(same_line)
}

/// The primitives of a part without materials, shared by its colour variants and by levels that have nothing coarser.
#[derive(Clone)]
struct PartShape {
    numbers: PointNumbers,
    faces: Vec<(Option<Colour>, Primitive)>,
    edges: Option<Primitive>,
}

/// A file that is being made.
#[derive(Default)]
struct Glb {
    options: GlbOptions,
    root: Root,
    materials: HashMap<[u32; 4], Index<Material>>,
    buffers: Buffers,
    uses: Uses,
}

/// Which extensions the file uses.
#[derive(Default)]
struct Uses {
    integers: bool,
    lists: bool,
    levels: bool,
}

impl Glb {
    /// Makes the JSON and the buffers.
    fn of(
        making: &Making<'_>,
        levels: &[MeshLevel<'_>],
        with: (GlbOptions, f64),
    ) -> Result<(Self, Vec<Rounding>), SaveError> {
        let mut glb = Self { options: with.0, ..Self::default() };
        let [MeshLevel { frame, .. }, coarser @ ..] = levels else { return Ok((glb, Vec::new())) };
        let (shapes, roundings) = glb.shapes(making, levels, with.1)?;
        let scales = frame.scene.largest_scales();
        let mut meshes = HashMap::new();
        let mut children = Vec::new();
        for group in groups(making.call, frame, with)? {
            making.goes_on()?;
            let Some((first, place)) = group.first() else { continue };
            let instance = &frame.scene.instances[*first];
            let row = instance.part.index();
            let part = &frame.scene.parts[row];
            let names: Vec<&str> =
                group.iter().map(|(row, _)| instance_name(&part.name, &frame.scene.instances[*row])).collect();
            let colour = instance.colour.map(|colour| colour.map(f32::to_bits));
            let mut mesh = |glb: &mut Self, level: usize| {
                let made = meshes.entry((level, instance.part, colour));
                *made.or_insert_with(|| glb.mesh(part, &shapes[level][row], instance.colour))
            };
            let (mut detail, mut listed) = (Detail::default(), None);
            let finest = mesh(&mut glb, 0);
            for (level, MeshLevel { chord, .. }) in (1..).zip(coarser).filter(|_| finest.is_some()) {
                let mesh = mesh(&mut glb, level);
                let with = (mesh, shapes[level][row].numbers);
                let node = glb.node((&group, &names), with, &Detail::default(), &mut listed)?;
                detail.add(node.value() as u32, 2.0 * part.radius * scales[row], *chord);
            }
            let inner = glb.node((&group, &names), (finest, shapes[0][row].numbers), &detail, &mut listed)?;
            children.push(place.around.iter().rev().fold(inner, |inner, around| {
                let (translation, children) = (Some(around.to_array()), Some(vec![inner]));
                glb.root.push(Node { translation, children, ..Node::default() })
            }));
        }
        let world = glb.root.push(Node {
            name: named(&frame.scene.name),
            matrix: Some(Y_UP),
            children: (!children.is_empty()).then_some(children),
            ..Node::default()
        });
        let scene = Scene { extensions: None, extras: None, name: named(&frame.scene.name), nodes: vec![world] };
        glb.root.scene = Some(glb.root.push(scene));
        Ok((glb, roundings))
    }

    /// The shapes of all parts in each level, and what rounding costs. Where a level has nothing coarser for a part, or
    /// no triangles, it shares the data of the level before.
    fn shapes(
        &mut self,
        making: &Making<'_>,
        levels: &[MeshLevel<'_>],
        most: f64,
    ) -> Result<(Vec<Vec<PartShape>>, Vec<Rounding>), SaveError> {
        let (mut shapes, mut roundings) = (Vec::<Vec<PartShape>>::new(), Vec::new());
        let (mut finer, mut counts) = (Vec::<PartRows<'_>>::new(), Vec::<RoundingCount>::new());
        for MeshLevel { frame, .. } in levels {
            // Readers do not draw lists of lines.
            let edge_lines = if self.options.instanced { &[] } else { frame.edge_lines };
            let lines = frame.by_part(edge_lines, |line| line.part);
            let rows: Vec<PartRows<'_>> = frame.batches_by_part().into_iter().zip(lines).collect();
            let of_points = PointNumbers::of(frame, self.options, most);
            let before = shapes.last();
            let shared: Vec<bool> =
                (0..rows.len()).map(|row| before.is_some() && is_same(making.call, &finer[row], &rows[row])).collect();
            let mut groups = Vec::new();
            let mut of_part = Vec::with_capacity(rows.len());
            for (row, (part, numbers)) in frame.scene.parts.iter().zip(&of_points).enumerate() {
                let first = groups.len();
                if shared[row] {
                    making.made(rows[row].0.len());
                } else {
                    groups.extend(groups_of((part, *numbers), &rows[row]));
                }
                of_part.push(first..groups.len());
            }
            let mut stored = numbers(making, &groups, self.options)?.into_iter();
            making.goes_on()?;
            let (mut made, mut counted) = (Vec::with_capacity(rows.len()), Vec::with_capacity(rows.len()));
            for (row, of_part) in of_part.into_iter().enumerate() {
                let before = before.map(|shapes| &shapes[row]);
                if let (Some(before), true) = (before, shared[row]) {
                    made.push(before.clone());
                    counted.push(std::mem::take(&mut counts[row]));
                    continue;
                }
                let mut shape = PartShape { numbers: of_points[row], faces: Vec::new(), edges: None };
                let mut count = RoundingCount::default();
                for (group, (numbers, of_group)) in groups[of_part].iter().zip(stored.by_ref()) {
                    count.add(of_group);
                    if numbers.corners > 0 {
                        let primitive = self.primitive(group, numbers)?;
                        match group.edges.is_empty() {
                            true => shape.faces.push((group.colour, primitive)),
                            false => shape.edges = Some(primitive),
                        }
                    }
                }
                let (shape, count) = match before {
                    Some(before) if shape.faces.is_empty() => (before.clone(), std::mem::take(&mut counts[row])),
                    _ => (shape, count),
                };
                counted.push(count);
                made.push(shape);
            }
            (finer, counts) = (rows, counted);
            shapes.push(made);
            roundings.push(Rounding::of_counts(making.call, frame, &counts, (self.options, most))?);
        }
        Ok((shapes, roundings))
    }

    fn primitive(&mut self, group: &Group<'_>, mut numbers: Numbers) -> io::Result<Primitive> {
        let is_lines = !group.edges.is_empty();
        let positions = self.positions(group.numbers.step, &mut numbers);
        let mut attributes = BTreeMap::from([(Valid(Semantic::Positions), positions)]);
        let Self { options, root, buffers, uses, .. } = self;
        let Numbers { vertices, corners, features, short_ids, short_indices, normals, ids, indices, .. } = numbers;
        let stream = if short_ids { Stream::ShortFeatures } else { Stream::Features };
        let ids = buffers.push(root, stream, vertices, ids);
        attributes.insert(Valid(Semantic::Extras("FEATURE_ID_0".into())), ids);
        if !is_lines {
            uses.integers |= options.quantized;
            let stream = if options.quantized { Stream::ShortNormals } else { Stream::Vectors };
            attributes.insert(Valid(Semantic::Normals), buffers.push(root, stream, vertices, normals));
        }
        // Triangles and lines are compressed differently.
        let stream = match (short_indices, options.is_compressed() && is_lines) {
            (true, false) => Stream::ShortIndices,
            (true, true) => Stream::ShortLines,
            (false, false) => Stream::LongIndices,
            (false, true) => Stream::LongLines,
        };
        let indices = Some(buffers.push(root, stream, corners, indices));
        let label = if is_lines { "edge" } else { "face" };
        let extensions = gltf_json::deserialize::from_str(&format!(
            r#"{{"EXT_mesh_features":{{"featureIds":[{{"featureCount":{features},"attribute":0,"label":"{label}"}}]}}}}"#
        ))?;
        let mode = Valid(if is_lines { Mode::Lines } else { Mode::Triangles });
        Ok(Primitive {
            attributes,
            extensions: Some(extensions),
            extras: None,
            indices,
            material: None,
            mode,
            targets: None,
        })
    }

    fn positions(&mut self, step: Option<f32>, numbers: &mut Numbers) -> Index<Accessor> {
        let Self { root, buffers, uses, .. } = self;
        uses.integers |= step.is_some();
        let stream = if step.is_some() { Stream::ShortVectors } else { Stream::Vectors };
        let accessor = buffers.push(root, stream, numbers.vertices, std::mem::take(&mut numbers.positions));
        let value = |corner: Vec3| match step {
            Some(_) => Value::from(corner.to_array().map(|x| x as i64).to_vec()),
            None => Value::from(corner.to_array().to_vec()),
        };
        let [low, high] = numbers.bounds.map(value);
        root.accessors[accessor.value()].min = Some(low);
        root.accessors[accessor.value()].max = Some(high);
        accessor
    }

    fn material(&mut self, colour: Colour) -> Index<Material> {
        let Self { root, materials, .. } = self;
        *materials.entry(colour.map(f32::to_bits)).or_insert_with(|| {
            let linear = linear(colour);
            root.push(Material {
                alpha_mode: Valid(if linear[3] < 1.0 { AlphaMode::Blend } else { AlphaMode::Opaque }),
                double_sided: true, // sheets show both sides, and files may contain reversed faces
                pbr_metallic_roughness: PbrMetallicRoughness {
                    base_color_factor: PbrBaseColorFactor(linear),
                    metallic_factor: StrengthFactor(0.0),
                    roughness_factor: StrengthFactor(0.5),
                    ..PbrMetallicRoughness::default()
                },
                ..Material::default()
            })
        })
    }

    /// Adds the part's mesh, in its own colours or all in `colour`. `None` if it is empty.
    fn mesh(&mut self, part: &ScenePart, shape: &PartShape, colour: Option<Colour>) -> Option<Index<Mesh>> {
        let mut primitives = Vec::new();
        for (own, primitive) in &shape.faces {
            let material = self.material(colour.or(*own).unwrap_or(DEFAULT_COLOUR));
            primitives.push(Primitive { material: Some(material), ..primitive.clone() });
        }
        if let Some(edges) = &shape.edges {
            let material = self.material(EDGE_COLOUR);
            primitives.push(Primitive { material: Some(material), ..edges.clone() });
        }
        if primitives.is_empty() {
            return None;
        }
        let mesh = Mesh { extensions: None, extras: None, name: named(&part.name), primitives, weights: None };
        Some(self.root.push(mesh))
    }

    /// Adds the node of a group of instances that has the mesh. The caller adds those around it. `listed`: translations
    /// and rotations of the group, once a node has made them.
    fn node(
        &mut self,
        (group, names): (&[(usize, NodePlace)], &[&str]),
        (mesh, numbers): (Option<Index<Mesh>>, PointNumbers),
        detail: &Detail,
        listed: &mut Option<[usize; 2]>,
    ) -> io::Result<Index<Node>> {
        let step = numbers.step.unwrap_or(1.0);
        let (mut extensions, mut extras) = (Vec::new(), Vec::new());
        let mut node = match (group, mesh) {
            ([(_, place)], _) => Node { name: named(names[0]), mesh, ..turned(place, step) },
            // Without a mesh there is nothing to list.
            (_, None) => Node::default(),
            (_, Some(_)) => {
                extensions.push(self.list(group, step, listed));
                extras.push(format!(r#""names":{}"#, gltf_json::serialize::to_string(names)?));
                let name = mesh.and_then(|mesh| self.root.get(mesh)).and_then(|mesh| mesh.name.clone());
                Node { name, mesh, ..Node::default() }
            }
        };
        self.uses.levels |= detail.extension().is_some();
        extensions.extend(detail.extension());
        extras.extend(detail.extra());
        if !extensions.is_empty() {
            let (extensions, extras) = (extensions.join(","), extras.join(","));
            node.extensions = Some(gltf_json::deserialize::from_str(&format!("{{{extensions}}}"))?);
            node.extras = Some(gltf_json::extras::RawValue::from_string(format!("{{{extras}}}"))?);
        }
        Ok(self.root.push(node))
    }

    /// Adds the places of several instances. Returns the extension of their node.
    fn list(&mut self, group: &[(usize, NodePlace)], step: f32, listed: &mut Option<[usize; 2]>) -> String {
        let Self { root, buffers, uses, .. } = self;
        uses.lists = true;
        let count = group.len();
        let turns = || {
            group.iter().map(|(_, NodePlace { turn, .. })| match turn {
                Turn::Rotation(rotation, scale) => (*rotation, scale * step),
                Turn::None | Turn::Axes(_) => ([0.0, 0.0, 0.0, 1.0], step),
            })
        };
        let [to, by] = *listed.get_or_insert_with(|| {
            let centres = group.iter().flat_map(|(_, place)| place.centre.to_array()).map(f32::to_le_bytes);
            let to = buffers.push(root, Stream::Translations, count, vec![bytes(centres)]);
            let turned = turns().flat_map(|(rotation, _)| rotation).map(f32::to_le_bytes);
            let by = buffers.push(root, Stream::Rotations, count, vec![bytes(turned)]);
            [to.value(), by.value()]
        });
        let scales = turns().flat_map(|(_, scale)| [scale; 3]).map(f32::to_le_bytes);
        let scales = buffers.push(root, Stream::Scales, count, vec![bytes(scales)]).value();
        let attributes = format!(r#"{{"TRANSLATION":{to},"ROTATION":{by},"SCALE":{scales}}}"#);
        format!(r#""EXT_mesh_gpu_instancing":{{"attributes":{attributes}}}"#)
    }

    /// The bytes of the file.
    fn finish(mut self, making: &Making<'_>) -> Result<Pieces, SaveError> {
        self.root.asset =
            Asset { generator: Some(concat!("trimtess ", env!("CARGO_PKG_VERSION")).into()), ..Asset::default() };
        let mut pieces = self.buffers.finish(making, &mut self.root, self.options)?;
        let total: u64 = pieces.iter().map(|piece| piece.len() as u64).sum();
        let padding = (total.next_multiple_of(4) - total) as usize;
        if total > 0 {
            let Uses { integers, lists, levels } = self.uses;
            let needed = [
                (integers, "KHR_mesh_quantization"),
                (lists, "EXT_mesh_gpu_instancing"),
                (self.options.is_compressed(), "EXT_meshopt_compression"),
            ];
            let needed = needed.into_iter().filter(|(is_used, _)| *is_used).map(|(_, name)| name.to_owned());
            self.root.extensions_required = needed.collect();
            self.root.extensions_used = vec!["EXT_mesh_features".into()];
            self.root.extensions_used.extend_from_slice(&self.root.extensions_required);
            self.root.extensions_used.extend(levels.then(|| "MSFT_lod".to_owned()));
        }
        let mut text = Text { bytes: Vec::new(), call: making.call };
        let told = self.root.to_writer(&mut text);
        making.goes_on()?;
        told.map_err(io::Error::from)?;
        let mut json = text.bytes;
        json.resize(json.len().next_multiple_of(4), b' ');
        let binary = total + padding as u64;
        let chunk = if total > 0 { 8 + binary } else { 0 };
        let length = 12 + 8 + json.len() as u64 + chunk;
        let length = counted(length, "bytes")?;
        let mut head = b"glTF".to_vec();
        head.extend([2, length, json.len() as u32].iter().flat_map(|word| word.to_le_bytes()));
        head.extend_from_slice(b"JSON");
        head.append(&mut json);
        if total > 0 {
            head.extend_from_slice(&(binary as u32).to_le_bytes());
            head.extend_from_slice(b"BIN\0");
            pieces.push(vec![0; padding]);
        }
        pieces.insert(0, head);
        Ok(pieces)
    }
}

/// Collects the bytes of a text, and refuses more once the caller asked to stop.
struct Text<'a> {
    bytes: Vec<u8>,
    call: Call<'a>,
}

impl Write for Text<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.write_all(bytes).map(|()| bytes.len())
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        /// Texts are written word by word.
        const LOOK_EVERY: usize = 1 << 12;
        let before = self.bytes.len() / LOOK_EVERY;
        self.bytes.extend_from_slice(bytes);
        if self.bytes.len() / LOOK_EVERY > before && self.call.is_cancelled() {
            return Err(io::Error::other("cancelled"));
        }
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// What the primitives of a part show: faces by colour, in the order of their first batches, then edges.
fn groups_of<'a>((part, numbers): (&'a ScenePart, PointNumbers), (batches, lines): &PartRows<'a>) -> Vec<Group<'a>> {
    let group = |colour| Group { part, numbers, colour, faces: Vec::new(), edges: Vec::new() };
    let mut groups: Vec<Group<'a>> = Vec::new();
    let mut of_colour = HashMap::new();
    for batch in batches {
        let colour = part.face_colours.get(batch.face.index()).copied().flatten();
        let at = *of_colour.entry(colour.map(|colour| colour.map(f32::to_bits))).or_insert_with(|| {
            groups.push(group(colour));
            groups.len() - 1
        });
        groups[at].faces.push(batch);
    }
    groups.extend((!lines.is_empty()).then(|| Group { edges: lines.clone(), ..group(None) }));
    groups
}

/// A node that turns and scales its mesh, whose numbers count steps.
fn turned(place: &NodePlace, step: f32) -> Node {
    let translation = Some(place.centre.to_array());
    let scale = |scale: f32| (scale != 1.0).then_some([scale; 3]);
    match place.turn {
        Turn::None => Node { translation, scale: scale(step), ..Node::default() },
        Turn::Rotation(rotation, by) => {
            Node { translation, rotation: Some(UnitQuaternion(rotation)), scale: scale(by * step), ..Node::default() }
        }
        Turn::Axes(axes) => {
            Node { matrix: Some(matrix(axes.map(|axis| axis * step), place.centre)), ..Node::default() }
        }
    }
}

/// A matrix by columns.
fn matrix([x, y, z]: [Vec3; 3], centre: Vec3) -> [f32; 16] {
    let column = |axis: Vec3, last: f32| axis.extend(last).to_array();
    let mut columns = [0.0; 16];
    columns.copy_from_slice([column(x, 0.0), column(y, 0.0), column(z, 0.0), column(centre, 1.0)].as_flattened());
    columns
}

fn named(name: &str) -> Option<String> {
    (!name.is_empty()).then(|| name.to_owned())
}
